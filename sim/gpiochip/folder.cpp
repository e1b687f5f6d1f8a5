#include "sim/gpiochip/folder.hpp"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <system_error>
#include <utility>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/ownership.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

// Stamps a little older than the chip stay representable.
constexpr std::int64_t kEpochMargin_ns = 3'600'000'000'000;
// Programs may run as another user than the rig.
constexpr mode_t kFileMode = 0666;
constexpr mode_t kFolderMode = 0777;

tl::unexpected<Error> system_failure(const std::string& what, int error) {
  return fail(what + ": " + std::generic_category().message(error));
}

Result<void> check(const ChipSpec& spec) {
  if (spec.lines.empty() || spec.lines.size() > kMaxLines) return fail("a simulated chip has 1 to 64 lines");
  const bool plain = spec.name.find('/') == std::string::npos && !spec.name.empty();
  if (!plain || spec.name.size() >= kNameSize) return fail("bad name of a simulated chip: " + spec.name);
  if (spec.label.size() >= kNameSize) return fail("label of a simulated chip is too long: " + spec.label);
  for (const LineSpec& line : spec.lines) {
    if (line.name.size() >= kNameSize) return fail("name of a line is too long: " + line.name);
    if (line.idle_level != 0 && line.idle_level != 1)
      return fail("idle level of a line is not 0 or 1: " + line.name);
    if (line.reset_pull < -1 || line.reset_pull > 1)
      return fail("pull of a line is not 0, 1 or -1: " + line.name);
  }
  return {};
}

struct Fifos {
  const char* prefix;
  std::size_t count;
};
/// All FIFOs of a chip beside its device.
std::array<Fifos, 3> fifos_of(std::size_t lines) {
  return {{{kEventPrefix, lines}, {kRequestPrefix, lines}, {kWatchPrefix, kMaxWatchers}}};
}
std::string numbered(const char* prefix, std::size_t number) { return prefix + std::to_string(number); }

std::uint64_t inode_of(const std::filesystem::path& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 ? status.st_ino : 0;
}

std::uint64_t device_of(const std::filesystem::path& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 ? status.st_dev : 0;
}

void fill_line(Line& line, const LineSpec& spec, std::uint64_t fifo_inode) {
  const bool idle = spec.idle_level != 0;
  std::uint64_t level = idle ? LevelWord::kOutside : 0;
  if (spec.reset_pull >= 0) level |= LevelWord::kPulled;
  if (spec.reset_pull == 1) level |= LevelWord::kPulledUp;
  line.level.store(level);
  line.config.store(spec.kernel_used ? ConfigWord::kKernelUsed : 0);
  line.idle_level = idle ? 1 : 0;
  memcpy(line.name, spec.name.data(), spec.name.size());
  line.fifo_inode = fifo_inode;
}

/// `state` is zero-filled memory.
void fill_state(State& state, const ChipSpec& spec, const std::filesystem::path& folder) {
  state.version = kVersion;
  state.line_count = static_cast<std::uint32_t>(spec.lines.size());
  state.input_on_release = spec.on_release == OnRelease::input ? 1 : 0;
  state.bias = spec.bias;
  memcpy(state.name, spec.name.data(), spec.name.size());
  memcpy(state.label, spec.label.data(), spec.label.size());
  state.epoch_ns = sys::now_ns() - kEpochMargin_ns;
  state.device_inode = inode_of(folder / kDeviceFile);
  state.lock_inode = inode_of(folder / kLockFile);
  state.folder_device = device_of(folder / kDeviceFile);
  for (std::size_t i = 0; i < spec.lines.size(); ++i) {
    fill_line(state.lines[i], spec.lines[i], inode_of(folder / numbered(kEventPrefix, i)));
    state.request_inodes[i] = inode_of(folder / numbered(kRequestPrefix, i));
  }
  for (std::size_t i = 0; i < kMaxWatchers; ++i) {
    state.watch_inodes[i] = inode_of(folder / numbered(kWatchPrefix, i));
  }
  clear_ring(state);
  state.magic.store(kMagic);
}

/// Creates a file that all users may access, whatever the umask.
int make_file(const std::filesystem::path& file, const std::string& text) {
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, kFileMode);
  if (fd < 0) return errno;
  const bool done = ::fchmod(fd, kFileMode) == 0 &&
                    ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = done ? 0 : errno;
  ::close(fd);
  return error;
}

int make_fifo(const std::filesystem::path& file) {
  if (::mkfifo(file.c_str(), kFileMode) != 0 || ::chmod(file.c_str(), kFileMode) != 0) return errno;
  return 0;
}

/// Both ends of each.
Result<void> open_fifos(const std::filesystem::path& folder, const char* prefix, std::size_t count,
                        std::vector<int>& fifos) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::filesystem::path file = folder / numbered(prefix, i);
    const int fifo = ::open(file.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (fifo < 0) return system_failure(file.string(), errno);
    fifos.push_back(fifo);
  }
  return {};
}

/// With all that is queued, if the device is gone: poll() then tells the end alone.
void close_fifos(std::vector<int>& fifos, bool emptied) {
  std::array<char, 4096> rest;
  for (int& fifo : fifos) {
    if (fifo < 0) continue;
    while (emptied && ::read(fifo, rest.data(), rest.size()) > 0) continue;
    ::close(std::exchange(fifo, -1));
  }
}

State* map(const std::filesystem::path& file) {
  const int fd = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return nullptr;
  struct stat status {};
  const bool whole = ::fstat(fd, &status) == 0 && status.st_size == static_cast<off_t>(sizeof(State));
  void* memory = whole ? sys::map_shared(fd, sizeof(State)) : nullptr;
  ::close(fd);
  return static_cast<State*>(memory);
}

/// A chip whose creator was killed is nobody's.
bool is_alive(const std::filesystem::path& folder) {
  const int fd = ::open((folder / kLockFile).c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return false;
  const bool locked = sys::is_locked(fd, kCreatorByte);
  ::close(fd);
  return locked;
}

void remove_chip_files(const std::filesystem::path& folder) {
  std::error_code ignored;
  for (const char* name : {kStateFile, "state.new", kLockFile, kDeviceFile, kSysfsFile, kTerminalFile}) {
    std::filesystem::remove(folder / name, ignored);
  }
  for (const Fifos& fifos : fifos_of(kMaxLines))
    for (std::size_t i = 0; i < fifos.count; ++i)
      std::filesystem::remove(folder / numbered(fifos.prefix, i), ignored);
}

}  // namespace

ChipFolder::ChipFolder(ChipFolder&& other) noexcept { *this = std::move(other); }

ChipFolder& ChipFolder::operator=(ChipFolder&& other) noexcept {
  if (this == &other) return *this;
  reset();
  path = std::move(other.path);
  state = std::exchange(other.state, nullptr);
  lock_fd = std::exchange(other.lock_fd, -1);
  events = std::exchange(other.events, {});
  requests = std::exchange(other.requests, {});
  watches_ = std::exchange(other.watches_, {});
  device_fd_ = std::exchange(other.device_fd_, -1);
  made_folder_ = std::exchange(other.made_folder_, false);
  made_chip_ = std::exchange(other.made_chip_, false);
  return *this;
}

ChipFolder::~ChipFolder() { reset(); }

Result<void> ChipFolder::make_files(std::size_t lines) {
  std::error_code error;
  made_folder_ = std::filesystem::create_directories(path, error);
  if (error) return fail("cannot create " + path.string() + ": " + error.message());
  if (made_folder_ && ::chmod(path.c_str(), kFolderMode) != 0) return system_failure(path.string(), errno);
  if (std::filesystem::exists(path / kStateFile) && is_alive(path)) {
    return fail("there is a simulated chip in " + path.string() + " already");
  }
  remove_chip_files(path);
  made_chip_ = true;
  int failed = make_file(path / kLockFile, "");
  if (failed == 0) failed = make_fifo(path / kDeviceFile);
  if (failed == 0) failed = make_file(path / kSysfsFile, std::to_string(kDeviceMajor) + ":0\n");
  for (const Fifos& fifos : fifos_of(lines))
    for (std::size_t i = 0; i < fifos.count && failed == 0; ++i)
      failed = make_fifo(path / numbered(fifos.prefix, i));
  if (failed != 0) return system_failure("cannot create a simulated chip in " + path.string(), failed);
  return {};
}

Result<void> ChipFolder::publish(const ChipSpec& spec) {
  const std::filesystem::path draft = path / "state.new";
  const int failed = make_file(draft, "");
  if (failed != 0) return system_failure(draft.string(), failed);
  if (::truncate(draft.c_str(), sizeof(State)) != 0) return system_failure(draft.string(), errno);
  state = map(draft);
  if (state == nullptr) return fail("cannot map " + draft.string());
  fill_state(*state, spec, path);
  if (::rename(draft.c_str(), (path / kStateFile).c_str()) != 0) return system_failure(draft.string(), errno);
  return {};
}

Result<void> ChipFolder::open_common(std::size_t lines) {
  lock_fd = ::open((path / kLockFile).c_str(), O_RDWR | O_CLOEXEC);
  if (lock_fd < 0) return system_failure((path / kLockFile).string(), errno);
  device_fd_ = ::open((path / kDeviceFile).c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (device_fd_ < 0) return system_failure((path / kDeviceFile).string(), errno);
  if (auto opened = open_fifos(path, kEventPrefix, lines, events); !opened) return opened;
  return open_fifos(path, kRequestPrefix, lines, requests);
}

Result<ChipFolder> ChipFolder::create(const std::filesystem::path& dir, const ChipSpec& spec) {
  if (const auto valid = check(spec); !valid) return tl::unexpected(valid.error());
  ChipFolder folder;
  folder.path = std::filesystem::absolute(dir);
  if (const auto made = folder.make_files(spec.lines.size()); !made) return tl::unexpected(made.error());
  if (const auto opened = folder.open_common(spec.lines.size()); !opened)
    return tl::unexpected(opened.error());
  if (const auto opened = open_fifos(folder.path, kWatchPrefix, kMaxWatchers, folder.watches_); !opened)
    return tl::unexpected(opened.error());
  if (sys::try_lock(folder.lock_fd, kCreatorByte, true) != 0) {
    return fail("another simulated chip is being created in " + folder.path.string());
  }
  if (const auto published = folder.publish(spec); !published) return tl::unexpected(published.error());
  return folder;
}

Result<ChipFolder> ChipFolder::attach(const std::filesystem::path& dir) {
  ChipFolder folder;
  folder.path = std::filesystem::absolute(dir);
  folder.state = map(folder.path / kStateFile);
  if (folder.state == nullptr) return fail("there is no simulated chip in " + folder.path.string());
  if (folder.state->magic.load() != kMagic || folder.state->version != kVersion) {
    return fail("the simulated chip in " + folder.path.string() + " is of another version");
  }
  if (const auto opened = folder.open_common(folder.state->line_count); !opened) {
    return tl::unexpected(opened.error());
  }
  return folder;
}

void ChipFolder::close_events() {
  const bool emptied = state != nullptr && state->unplugged.load() != 0;
  for (std::vector<int>* fifos : {&events, &requests, &watches_}) close_fifos(*fifos, emptied);
  if (device_fd_ >= 0) ::close(std::exchange(device_fd_, -1));
}

void ChipFolder::reset() {
  if (made_chip_) {
    if (state != nullptr) {
      state->unplugged.store(1);
      notify(*state);
    }
    remove_chip_files(path);
    std::error_code ignored;
    if (made_folder_) std::filesystem::remove(path, ignored);  // only if empty
  }
  close_events();
  for (std::vector<int>* fifos : {&events, &requests, &watches_}) fifos->clear();
  if (lock_fd >= 0) ::close(std::exchange(lock_fd, -1));
  made_chip_ = made_folder_ = false;
  if (state == nullptr) return;
  leave(*state);
  sys::unmap(std::exchange(state, nullptr), sizeof(State));
}

}  // namespace strobe::sim::gpio
