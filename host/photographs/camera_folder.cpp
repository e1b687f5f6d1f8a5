#include "host/photographs/camera_folder.hpp"

#include <fcntl.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>

#include "host/external/raw_file.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

constexpr Duration kScanEvery = std::chrono::seconds{1};
constexpr std::array<std::string_view, 5> kKinds{".tif", ".tiff", ".png", ".jpg", ".jpeg"};
constexpr std::array<std::string_view, 5> kUnfinished{"~", ".tmp", ".temp", ".part", ".partial"};

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

}  // namespace

Result<std::unique_ptr<CameraFolder>> CameraFolder::open(const fs::path& folder, HostTime now) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return fail(folder.string() + ": no such folder");
  const int inotify = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (inotify < 0) return fail(folder.string() + ": cannot be watched: " + std::strerror(errno));
  std::unique_ptr<CameraFolder> result(new CameraFolder(folder, inotify));
  if (!result->watch()) return fail(folder.string() + ": cannot be watched: " + std::strerror(errno));
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    Identity identity;
    const std::string name = entry.path().filename().string();
    if (result->identify(name, identity)) result->known_[name] = identity;
  }
  if (error) return fail(folder.string() + ": " + error.message());
  result->scanned_ = now;
  result->old_ = result->known_;
  return result;
}

CameraFolder::~CameraFolder() {
  if (inotify_ >= 0) close(inotify_);
}

bool CameraFolder::watch() {
  watch_ = inotify_add_watch(inotify_, folder_.c_str(),
                             IN_CLOSE_WRITE | IN_MOVED_TO | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR);
  return watch_ >= 0;
}

bool CameraFolder::identify(const std::string& name, Identity& identity) const {
  struct stat status {};
  if (stat((folder_ / name).c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  identity.inode = status.st_ino;
  identity.size = status.st_size;
  identity.changed = WallTime{std::chrono::seconds{status.st_mtim.tv_sec} + Duration{status.st_mtim.tv_nsec}};
  return true;
}

bool CameraFolder::wanted(const std::string& name) {
  if (name.empty() || name.front() == '.') return false;
  const std::string lower = lower_case(name);
  const auto ends = [&lower](std::string_view end) { return lower.ends_with(end); };
  if (std::any_of(kUnfinished.begin(), kUnfinished.end(), ends)) return false;
  if (std::any_of(kKinds.begin(), kKinds.end(), ends) || external::is_raw_name(name)) return true;
  if (said_kinds_.insert(fs::path(lower).extension().string()).second) {
    notifications_.push_back(name + ": not a TIFF, PNG, JPEG or RAW file");
  }
  return false;
}

void CameraFolder::consider(const std::string& name, bool renamed, HostTime now,
                            std::vector<Arrival>& arrivals) {
  Identity identity;
  if (!identify(name, identity)) return;
  const auto known = known_.find(name);
  if (known != known_.end() && known->second == identity) return;
  known_[name] = identity;
  changing_.erase(name);
  if (!wanted(name)) return;
  const Duration age = std::chrono::system_clock::now() - identity.changed;
  arrivals.push_back({folder_ / name, now, now - age, renamed});
}

void CameraFolder::take_events(HostTime now, std::vector<Arrival>& arrivals) {
  alignas(inotify_event) std::array<char, 16384> buffer{};
  while (true) {
    const ssize_t size = read(inotify_, buffer.data(), buffer.size());
    if (size <= 0) return;
    for (std::size_t at = 0; at + sizeof(inotify_event) <= static_cast<std::size_t>(size);) {
      inotify_event event{};
      std::memcpy(&event, buffer.data() + at, sizeof event);
      const char* name = buffer.data() + at + sizeof event;
      if (event.mask & IN_Q_OVERFLOW) rescan_ = true;
      if (event.wd == watch_ && (event.mask & (IN_IGNORED | IN_DELETE_SELF | IN_MOVE_SELF | IN_UNMOUNT)))
        watch_ = -1;
      if (event.len > 0 && (event.mask & (IN_CLOSE_WRITE | IN_MOVED_TO)))
        consider(name, (event.mask & IN_MOVED_TO) != 0, now, arrivals);
      at += sizeof event + event.len;
    }
  }
}

/// A file that the kernel did not tell of has arrived when it is the same as a second ago.
void CameraFolder::scan(HostTime now, std::vector<Arrival>& arrivals) {
  std::map<std::string, Identity> before = std::exchange(changing_, {});
  std::error_code error;
  std::vector<std::string> whole;
  std::set<std::string> there;
  for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    there.insert(name);
    Identity identity;
    if (!identify(name, identity)) continue;
    const auto known = known_.find(name);
    if (known != known_.end() && known->second == identity) continue;
    const auto last = before.find(name);
    if (last != before.end() && last->second == identity) {
      whole.push_back(name);
    } else {
      changing_[name] = identity;
    }
  }
  if (error) return;
  std::sort(whole.begin(), whole.end());
  for (const std::string& name : whole) consider(name, false, now, arrivals);
  std::erase_if(known_, [&there](const auto& entry) { return !there.contains(entry.first); });
}

std::vector<OldFile> CameraFolder::old_files() {
  std::vector<OldFile> files;
  for (const auto& [name, before] : old_) {
    Identity identity;
    if (identify(name, identity) && identity == before && wanted(name))
      files.push_back({folder_ / name, HostTime{before.changed.time_since_epoch()}});
  }
  return files;
}

std::vector<Arrival> CameraFolder::look(HostTime now) {
  std::vector<Arrival> arrivals;
  const bool watched = watch_ >= 0;
  take_events(now, arrivals);
  if (watched && watch_ < 0)
    notifications_.push_back(folder_.string() + ": the folder of photographs is gone");
  if (now - scanned_ >= kScanEvery || rescan_) {
    scanned_ = now;
    rescan_ = false;
    if (watch_ < 0 && watch())
      notifications_.push_back(folder_.string() + ": the folder of photographs is back");
    scan(now, arrivals);
  }
  return arrivals;
}

}  // namespace strobe::host
