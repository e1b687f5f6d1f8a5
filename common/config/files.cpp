#include "common/config/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

namespace strobe::config {
namespace {

namespace fs = std::filesystem;

struct FileCloser {
  void operator()(std::FILE* file) const {
    if (file != stdin) std::fclose(file);
  }
};

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }
  /// Some file systems say only now what could not be written.
  bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

tl::unexpected<Error> because(const fs::path& path) {
  return fail(path.string() + ": cannot be written: " + std::strerror(errno));
}

/// What cannot be synced, such as a pipe, has nothing to lose.
bool synced(int fd) { return ::fsync(fd) == 0 || errno == EINVAL || errno == ENOTSUP; }

template <typename Fill>
Result<void> write_in_place(const fs::path& path, const Fill& fill) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (file.get() < 0 || !fill(file.get()) || !file.close()) return because(path);
  return {};
}

template <typename Fill>
Result<void> replace(const fs::path& path, const fs::file_status& before, const Fill& fill) {
  const std::string draft = path.string() + "." + std::to_string(::getpid()) + ".new";
  const bool exists = fs::is_regular_file(before);
  if (exists && ::access(path.c_str(), W_OK) != 0) return because(path);
  Descriptor file(::open(draft.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) return because(path);
  const auto mode = static_cast<mode_t>(before.permissions()) & 0777;
  const bool good = (!exists || ::fchmod(file.get(), mode) == 0) && fill(file.get()) && synced(file.get()) &&
                    file.close() && ::rename(draft.c_str(), path.c_str()) == 0 &&
                    sync_folder(path.parent_path());
  if (good) return {};
  const int why = errno;
  ::unlink(draft.c_str());
  errno = why;
  return because(path);
}

using OnLine = std::function<void(std::string_view, bool)>;

/// Of a line that goes on in the next block, `begun` holds what there was of it.
void take_lines(std::string_view block, std::string& begun, const OnLine& on_line) {
  for (std::size_t end = block.find('\n'); end != std::string_view::npos; end = block.find('\n')) {
    begun += block.substr(0, end);
    on_line(begun, true);
    begun.clear();
    block.remove_prefix(end + 1);
  }
  begun += block;
}

}  // namespace

Result<std::string> read_file(const std::string& path) {
  constexpr std::size_t kMaxBytes = 16u << 20;
  const std::unique_ptr<std::FILE, FileCloser> file(path == "-" ? stdin : std::fopen(path.c_str(), "rb"));
  if (!file) return fail(path + ": " + std::strerror(errno));
  std::string text;
  std::array<char, 65536> block{};
  while (const std::size_t n = std::fread(block.data(), 1, block.size(), file.get())) {
    text.append(block.data(), n);
    if (text.size() > kMaxBytes) return fail(path + ": larger than 16 MB");
  }
  if (std::ferror(file.get())) return fail(path + ": " + std::strerror(errno));
  return text;
}

Result<std::optional<std::string>> read_file_if_any(const fs::path& path) {
  auto text = read_file(path.string());
  if (text) return std::optional(std::move(*text));
  std::error_code error;
  if (fs::status(path, error).type() == fs::file_type::not_found) return std::optional<std::string>();
  return tl::unexpected(text.error());
}

Result<bool> read_lines(const fs::path& path, const OnLine& on_line) {
  const std::unique_ptr<std::FILE, FileCloser> file(std::fopen(path.c_str(), "rbe"));
  if (!file && errno == ENOENT) return false;
  if (!file) return fail(path.string() + ": " + std::strerror(errno));
  std::string begun;
  std::array<char, 65536> block{};
  while (const std::size_t size = std::fread(block.data(), 1, block.size(), file.get())) {
    take_lines({block.data(), size}, begun, on_line);
    if (begun.size() > kMaxLine_bytes) return fail(path.string() + ": a line is longer than 1 MB");
  }
  if (std::ferror(file.get())) return fail(path.string() + ": " + std::strerror(errno));
  if (!begun.empty()) on_line(begun, false);
  return true;
}

bool write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = EIO;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

bool sync_folder(const fs::path& folder) {
  const Descriptor opened(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return opened.get() >= 0 && synced(opened.get());
}

Result<void> write_file(const fs::path& path, std::string_view text) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const auto fill = [text](int fd) { return write_all(fd, text); };
  if (fs::exists(status) && !fs::is_regular_file(status)) return write_in_place(path, fill);
  return replace(fs::is_symlink(path, error) ? fs::weakly_canonical(path, error) : path, status, fill);
}

Result<void> copy_file(const fs::path& from, const fs::path& to) {
  const Descriptor source(::open(from.c_str(), O_RDONLY | O_CLOEXEC));
  if (source.get() < 0) return fail(from.string() + ": " + std::strerror(errno));
  return replace(to, fs::file_status(), [&source](int fd) {
    std::vector<char> block(std::size_t{1} << 20);
    while (true) {
      const ssize_t size = ::read(source.get(), block.data(), block.size());
      if (size < 0 && errno == EINTR) continue;
      if (size <= 0) return size == 0;
      if (!write_all(fd, {block.data(), static_cast<std::size_t>(size)})) return false;
    }
  });
}

Result<std::filesystem::path> share_folder() {
  std::error_code error;
  fs::path folder;
  if (const char* given = std::getenv("STROBE_SHARE"); given && *given) {
    folder = given;
  } else {
    const fs::path self = fs::read_symlink("/proc/self/exe", error);
    if (error) return fail("cannot find the program's own folder: " + error.message());
    folder = self.parent_path().parent_path() / "share" / "strobe";
  }
  if (!fs::is_directory(folder, error)) {
    return fail(folder.string() + ": no such folder (STROBE_SHARE names the one with scenes and tables)");
  }
  return folder;
}

}  // namespace strobe::config
