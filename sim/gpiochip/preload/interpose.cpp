// The libc functions through which a program accesses the chip. Calls on anything else go to the next
// library.
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include "sim/gpiochip/preload/next.hpp"
#include "sim/gpiochip/preload/uapi.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

namespace gpio = strobe::sim::gpio;
using gpio::Kind;
using gpio::Node;

namespace {

long answer(long result) {
  if (result >= 0) return result;
  errno = static_cast<int>(-result);
  return -1;
}

bool backing_path(Node node, char (&path)[gpio::kPathSize]) {
  return gpio::path_in(gpio::device().folder, node == Node::sysfs ? gpio::kSysfsFile : gpio::kDeviceFile,
                       path);
}

int refused() { return gpio::device().wrong ? -ENODEV : -ENOENT; }

/// Opens one of ours. True if `path` is ours, with the descriptor or the negated errno in `result`.
bool open_ours(const char* path, int flags, int& result) {
  const Node node = gpio::node_of(path);
  if (node == Node::other) return false;
  constexpr int kKept = O_ACCMODE | O_CLOEXEC | O_NONBLOCK;
  char backing[gpio::kPathSize];
  result = refused();
  if (node == Node::device) {
    result = gpio::open_chip(flags & kKept);
  } else if (node == Node::sysfs && backing_path(node, backing)) {
    result = gpio::sys::open(backing, flags & kKept);
  }
  return true;
}

mode_t mode_argument(int flags, va_list arguments) {
  const bool given = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  return given ? va_arg(arguments, mode_t) : 0;
}

using OpenFunction = int(const char*, int, ...);

int open_any(OpenFunction* native, const char* path, int flags, mode_t mode) {
  int result = 0;
  return open_ours(path, flags, result) ? static_cast<int>(answer(result)) : native(path, flags, mode);
}

/// As an open of one of ours, for the status of a file.
bool status_ours(const char* path, struct stat* status, int& result) {
  const Node node = gpio::node_of(path);
  if (node == Node::other) return false;
  char backing[gpio::kPathSize];
  result = refused();
  if (node == Node::missing || !backing_path(node, backing)) return true;
  const int fd = gpio::sys::open(backing, O_PATH | O_CLOEXEC);
  result = fd;
  if (fd < 0) return true;
  static auto* const next = gpio::next<int(int, struct stat*)>("fstat");
  result = next(fd, status) == 0 ? 0 : -errno;
  gpio::sys::close(fd);
  if (node == Node::device && result == 0) {
    status->st_mode = S_IFCHR | (status->st_mode & 0777);
    status->st_rdev = makedev(gpio::kDeviceMajor, 0);
    status->st_size = 0;
  }
  return true;
}

/// A read that ended with nothing: no file of ours does that in the kernel.
long read_nothing(int fd) {
  switch (gpio::describe(fd).kind) {
    case Kind::handle:
      return answer(-EINVAL);
    case Kind::event:
    case Kind::request:
    case Kind::chip:
      return answer(-ENODEV);  // the rig closed its end
    default:
      return 0;
  }
}

using ReadFunction = ssize_t(int, void*, size_t);

ssize_t read_any(ReadFunction* native, int fd, void* data, size_t size) {
  if (!gpio::is_whole_for_all(size)) {
    const long whole = gpio::whole_records(fd, size);
    if (whole < 0) return answer(whole);
    size = static_cast<size_t>(whole);
  }
  const ssize_t result = native(fd, data, size);
  return result == 0 && size > 0 && gpio::device().state != nullptr ? read_nothing(fd) : result;
}

using ScanFilter = int(const struct dirent*);
using ScanOrder = int(const struct dirent**, const struct dirent**);
using ScanFunction = int(const char*, struct dirent***, ScanFilter*, ScanOrder*);

/// Adds the chip's node to a listing of /dev that does not have that name yet.
int add_node(int count, struct dirent*** list, ScanFilter* filter, ScanOrder* order) {
  const char* name = gpio::device().state->name;
  for (int i = 0; i < count; ++i) {
    if (strcmp((*list)[i]->d_name, name) == 0) return count;
  }
  auto* entry = static_cast<struct dirent*>(calloc(1, sizeof(struct dirent)));
  if (entry == nullptr) return count;
  entry->d_ino = 1;
  entry->d_type = DT_CHR;
  entry->d_reclen = sizeof(struct dirent);
  snprintf(entry->d_name, sizeof(entry->d_name), "%s", name);
  auto** longer = filter == nullptr || filter(entry) != 0
                      ? static_cast<struct dirent**>(
                            realloc(*list, (static_cast<size_t>(count) + 1) * sizeof(struct dirent*)))
                      : nullptr;
  if (longer == nullptr) {
    free(entry);
    return count;
  }
  int place = count;
  const struct dirent* added = entry;
  while (place > 0 && order != nullptr) {
    const struct dirent* before = longer[place - 1];
    if (order(&before, &added) <= 0) break;
    longer[place] = longer[place - 1];
    --place;
  }
  longer[place] = entry;
  *list = longer;
  return count + 1;
}

int scan_any(ScanFunction* native, const char* folder, struct dirent*** list, ScanFilter* filter,
             ScanOrder* order) {
  const int count = native(folder, list, filter, order);
  const bool is_dev = strcmp(folder, "/dev") == 0 || strcmp(folder, "/dev/") == 0;
  return count < 0 || !is_dev || !gpio::present() ? count : add_node(count, list, filter, order);
}

}  // namespace

#define STROBE_NEXT(type, name)                       \
  ([]() -> type* {                                    \
    static type* const next = gpio::next<type>(name); \
    return next;                                      \
  }())

STROBE_EXPORT int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_argument(flags, arguments);
  va_end(arguments);
  return open_any(STROBE_NEXT(OpenFunction, "open"), path, flags, mode);
}

STROBE_EXPORT int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = mode_argument(flags, arguments);
  va_end(arguments);
  return open_any(STROBE_NEXT(OpenFunction, "open64"), path, flags, mode);
}

// What open() becomes under _FORTIFY_SOURCE.
STROBE_EXPORT int __open_2(const char* path, int flags) {
  return open_any(STROBE_NEXT(OpenFunction, "open"), path, flags, 0);
}
STROBE_EXPORT int __open64_2(const char* path, int flags) {
  return open_any(STROBE_NEXT(OpenFunction, "open64"), path, flags, 0);
}
using FopenFunction = FILE*(const char*, const char*);

namespace {
FILE* fopen_any(FopenFunction* native, const char* path, const char* mode) {
  char backing[gpio::kPathSize];
  const bool ours = gpio::node_of(path) == Node::sysfs && backing_path(Node::sysfs, backing);
  return native(ours ? backing : path, mode);
}
}  // namespace

STROBE_EXPORT FILE* fopen(const char* path, const char* mode) {
  return fopen_any(STROBE_NEXT(FopenFunction, "fopen"), path, mode);
}
STROBE_EXPORT FILE* fopen64(const char* path, const char* mode) {
  return fopen_any(STROBE_NEXT(FopenFunction, "fopen64"), path, mode);
}

using StatFunction = int(const char*, struct stat*);

STROBE_EXPORT int stat(const char* path, struct stat* status) noexcept {
  int result = 0;
  if (status_ours(path, status, result)) return static_cast<int>(answer(result));
  return STROBE_NEXT(StatFunction, "stat")(path, status);
}
STROBE_EXPORT int lstat(const char* path, struct stat* status) noexcept {
  int result = 0;
  if (status_ours(path, status, result)) return static_cast<int>(answer(result));
  return STROBE_NEXT(StatFunction, "lstat")(path, status);
}
static_assert(sizeof(struct stat) == sizeof(struct stat64));
STROBE_EXPORT int stat64(const char* path, struct stat64* status) noexcept {
  return stat(path, reinterpret_cast<struct stat*>(status));
}
STROBE_EXPORT int lstat64(const char* path, struct stat64* status) noexcept {
  return lstat(path, reinterpret_cast<struct stat*>(status));
}
STROBE_EXPORT int access(const char* path, int mode) noexcept {
  using Function = int(const char*, int);
  auto* native = STROBE_NEXT(Function, "access");
  const Node node = gpio::node_of(path);
  if (node == Node::other) return native(path, mode);
  char backing[gpio::kPathSize];
  if (node == Node::missing || !backing_path(node, backing)) return static_cast<int>(answer(refused()));
  return native(backing, mode);
}

namespace {
/// The subsystem of the chip's device number, by which libgpiod 2 knows a GPIO chip. Compared before anything
/// else is looked at: the search for the chip's folder itself comes through here.
bool is_subsystem(const char* path) {
  constexpr const char* kPrefix = "/sys/dev/char/";
  if (path == nullptr || strncmp(path, kPrefix, strlen(kPrefix)) != 0) return false;
  char ours[64];
  snprintf(ours, sizeof(ours), "%s%u:0/subsystem", kPrefix, gpio::kDeviceMajor);
  return strcmp(path, ours) == 0 && gpio::present();
}
}  // namespace

STROBE_EXPORT char* realpath(const char* path, char* resolved) noexcept {
  using Function = char*(const char*, char*);
  constexpr char kSubsystem[] = "/sys/bus/gpio";
  if (!is_subsystem(path)) return STROBE_NEXT(Function, "realpath")(path, resolved);
  if (resolved == nullptr) return strdup(kSubsystem);
  memcpy(resolved, kSubsystem, sizeof(kSubsystem));
  return resolved;
}

STROBE_EXPORT int scandir(const char* folder, struct dirent*** list, ScanFilter* filter, ScanOrder* order) {
  return scan_any(STROBE_NEXT(ScanFunction, "scandir"), folder, list, filter, order);
}
static_assert(sizeof(struct dirent) == sizeof(struct dirent64));
STROBE_EXPORT int scandir64(const char* folder, struct dirent64*** list,
                            int (*filter)(const struct dirent64*),
                            int (*order)(const struct dirent64**, const struct dirent64**)) {
  return scan_any(STROBE_NEXT(ScanFunction, "scandir64"), folder, reinterpret_cast<struct dirent***>(list),
                  reinterpret_cast<ScanFilter*>(filter), reinterpret_cast<ScanOrder*>(order));
}

STROBE_EXPORT ssize_t read(int fd, void* data, size_t size) {
  return read_any(STROBE_NEXT(ReadFunction, "read"), fd, data, size);
}
STROBE_EXPORT ssize_t __read_chk(int fd, void* data, size_t size, size_t room) {
  if (size > room) abort();
  return read_any(STROBE_NEXT(ReadFunction, "read"), fd, data, size);
}

// What strobed's loop leaves for its other threads reaches them once it sleeps (rig_time.hpp).
STROBE_EXPORT ssize_t write(int fd, const void* data, size_t size) {
  using Function = ssize_t(int, const void*, size_t);
  std::uint64_t value = 0;
  if (size == sizeof(value) && gpio::is_loop()) {
    memcpy(&value, data, sizeof(value));
    if (gpio::put_off_write(fd, value)) return static_cast<ssize_t>(size);
  }
  const auto native = [&] { return STROBE_NEXT(Function, "write")(fd, data, size); };
  gpio::State* state = gpio::device().state;
  if (state == nullptr || !gpio::is_terminal(*state, fd)) return native();
  return answer(gpio::write_to_terminal(*state, gpio::device().folder, data, size));
}

STROBE_EXPORT int ioctl(int fd, unsigned long given, ...) noexcept {
  using Function = int(int, unsigned long, ...);
  const unsigned request = static_cast<unsigned>(given);  // all that the kernel looks at
  va_list arguments;
  va_start(arguments, given);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  constexpr unsigned kGpioType = 0xB4;
  const bool known_type = _IOC_TYPE(request) == kGpioType;
  const bool is_inert = gpio::device().state == nullptr;
  if (is_inert || !known_type) {
    const int result = STROBE_NEXT(Function, "ioctl")(fd, given, argument);
    // The kernel's chip, handles and events answer EINVAL to what they do not know, terminal calls included.
    const bool suspect = !is_inert && ((result < 0 && errno == ENOTTY) || request == FIONREAD);
    if (!suspect || gpio::describe(fd).kind == Kind::none) return result;
    return static_cast<int>(answer(-EINVAL));
  }
  const bool for_request =
      request == GPIO_V2_LINE_SET_VALUES_IOCTL || request == GPIO_V2_LINE_GET_VALUES_IOCTL;
  const gpio::Descriptor descriptor = for_request ? gpio::describe_request_first(fd) : gpio::describe(fd);
  switch (descriptor.kind) {
    case Kind::chip:
      return static_cast<int>(answer(gpio::chip_ioctl(descriptor.index, request, argument)));
    case Kind::handle:
      return static_cast<int>(answer(gpio::handle_ioctl(descriptor.index, request, argument)));
    case Kind::event:
      return static_cast<int>(answer(gpio::event_ioctl(descriptor.index, request, argument)));
    case Kind::request:
      return static_cast<int>(answer(gpio::request_ioctl(descriptor.index, request, argument)));
    default:
      return STROBE_NEXT(Function, "ioctl")(fd, given, argument);
  }
}
