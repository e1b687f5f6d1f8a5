#include "host/batch/batch_journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::int64_t kNs_per_s = 1'000'000'000;

std::string text_in(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::int64_t number_in(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
}

std::string failure(const fs::path& path) { return path.string() + ": " + std::strerror(errno); }

}  // namespace

BatchJournal::~BatchJournal() {
  if (fd_ >= 0) ::close(fd_);
}

/// Returns false if it is no row.
bool BatchJournal::load_line(const std::string& line) {
  const json object = messages::parsed_json<json>(line);
  if (!object.is_object()) return false;
  const std::string key = text_in(object, "key"), results = text_in(object, "results");
  if (key.empty() || results.empty()) return false;
  rows_[key] = {results, number_in(object, "failed") != 0};
  PhotographStamp stamp{text_in(object, "photograph"), number_in(object, "size"),
                        number_in(object, "changed_ns"), text_in(object, "hash")};
  if (!stamp.hash.empty()) stamps_[stamp.path] = std::move(stamp);
  return true;
}

Result<void> BatchJournal::load(const fs::path& path, bool own) {
  std::ifstream file(path, std::ios::binary);
  off_t whole = 0;
  bool torn = false;
  for (std::string line; std::getline(file, line);) {
    torn = file.eof();  // without its end: cut short
    if (torn) break;
    load_line(line);
    whole += static_cast<off_t>(line.size()) + 1;
  }
  if (!file.is_open() || file.bad()) return fail(failure(path));
  if (own && torn && ::ftruncate(fd_, whole) != 0) return fail(failure(path));
  return {};
}

Result<std::unique_ptr<BatchJournal>> BatchJournal::open(const fs::path& folder, const std::string& name) {
  std::unique_ptr<BatchJournal> journal(new BatchJournal);
  journal->path_ = folder / name;
  journal->fd_ = ::open(journal->path_.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  if (journal->fd_ < 0) return fail(failure(journal->path_));
  struct stat opened {};
  if (::fstat(journal->fd_, &opened) != 0 || !S_ISREG(opened.st_mode))
    return fail(journal->path_.string() + ": not a regular file");
  if (::flock(journal->fd_, LOCK_EX | LOCK_NB) != 0)
    return fail(journal->path_.string() + ": another batch is writing it");
  std::vector<fs::path> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string file = entry.path().filename().string();
    if (file.starts_with("done") && file.ends_with(".jsonl")) paths.push_back(entry.path());
  }
  if (error) return fail(folder.string() + ": " + error.message());
  std::ranges::sort(paths);
  for (const fs::path& path : paths) {
    if (auto loaded = journal->load(path, path == journal->path_); !loaded)
      return tl::unexpected(loaded.error());
  }
  if (!config::sync_folder(folder)) return fail(failure(folder));
  return journal;
}

std::optional<BatchRow> BatchJournal::find(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = rows_.find(key);
  return found == rows_.end() ? std::nullopt : std::optional(found->second);
}

Result<PhotographStamp> BatchJournal::stamp(const fs::path& photograph) const {
  struct stat now {};
  if (::stat(photograph.c_str(), &now) != 0) return fail(failure(photograph));
  PhotographStamp stamp{
      photograph.string(), now.st_size, now.st_mtim.tv_sec * kNs_per_s + now.st_mtim.tv_nsec, {}};
  {
    const std::lock_guard lock(mutex_);
    const auto known = stamps_.find(stamp.path);
    if (known != stamps_.end() && known->second.size == stamp.size &&
        known->second.changed_ns == stamp.changed_ns)
      return known->second;
  }
  const auto hash = hash_of_file(stamp.path);
  if (!hash) return tl::unexpected(hash.error());
  stamp.hash = *hash;
  return stamp;
}

Result<void> BatchJournal::add(const std::string& key, const BatchRow& row,
                               const std::optional<PhotographStamp>& photograph) {
  nlohmann::ordered_json object;
  object["key"] = key;
  object["results"] = row.results;
  object["failed"] = row.failed ? 1 : 0;
  if (photograph) {
    object["photograph"] = photograph->path;
    object["size"] = photograph->size;
    object["changed_ns"] = photograph->changed_ns;
    object["hash"] = photograph->hash;
  }
  const std::string line = messages::json_text(object) + "\n";
  const std::lock_guard lock(mutex_);
  if (!config::write_all(fd_, line) || ::fdatasync(fd_) != 0) return fail(failure(path_));
  rows_[key] = row;
  return {};
}

}  // namespace strobe::host
