#include "common/authentication/key_file.hpp"

#include <fcntl.h>
#include <pwd.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

namespace strobe::authentication {

namespace fs = std::filesystem;

namespace {

/// Who looks after the file.
enum class Keeper {
  user,     ///< the one who runs this program
  systemd,  ///< a credential: root's file, which this user may read by an access list shown as the group's
            ///< right
};

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

tl::unexpected<Error> bad(const fs::path& path, const std::string& what) {
  return fail(path.string() + ": " + what);
}

std::string make_one(const fs::path& path) { return "make one with: strobe key --new " + path.string(); }

/// What is wrong with the file's owner and rights; empty: nothing.
std::string rights_fault(const struct stat& file, const fs::path& path, Keeper keeper) {
  if (!S_ISREG(file.st_mode)) return "the key must be a regular file; " + make_one(path);
  const bool trusted = file.st_uid == geteuid() || (keeper == Keeper::systemd && file.st_uid == 0);
  if (!trusted) {
    return "the key belongs to user " + std::to_string(file.st_uid) + " and must belong to user " +
           std::to_string(geteuid()) + ", who runs this; run: chown " + std::to_string(geteuid()) + " " +
           path.string();
  }
  const mode_t forbidden = keeper == Keeper::systemd ? S_IWGRP | S_IRWXO : S_IRWXG | S_IRWXO;
  if ((file.st_mode & forbidden) == 0) return "";
  return "others can read or change the key; run: chmod 600 " + path.string();
}

Result<Key> read_key(const fs::path& path, Keeper keeper) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (file.get() < 0) {
    return bad(path, errno == ENOENT ? "there is no such key; " + make_one(path)
                                     : std::string("the key cannot be read: ") + std::strerror(errno));
  }
  struct stat status {};
  if (fstat(file.get(), &status) != 0) return bad(path, std::strerror(errno));
  if (const std::string fault = rights_fault(status, path, keeper); !fault.empty()) return bad(path, fault);
  std::array<char, 2 * Key::kBytes + 8> text{};  // room for a line's end, not for a longer file
  const ssize_t size = read(file.get(), text.data(), text.size());
  if (size < 0) return bad(path, std::strerror(errno));
  auto key = Key::from_text({text.data(), static_cast<std::size_t>(size)});
  sodium_memzero(text.data(), text.size());
  if (!key) return bad(path, key.error().message + "; " + make_one(path) + " (after removing it)");
  return *key;
}

bool write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(fd, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return fsync(fd) == 0;
}

bool sync_folder(const fs::path& folder) {
  const Descriptor opened(open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return opened.get() >= 0 && (fsync(opened.get()) == 0 || errno == EINVAL || errno == ENOTSUP);
}

/// Writes the key to a file of a name of its own, then gives it the name wanted, which only one can get.
Result<void> write_new(const Key& key, const fs::path& path) {
  std::string own_name = path.string() + ".XXXXXX";
  const Descriptor file(mkostemp(own_name.data(), O_CLOEXEC));  // mode 600
  if (file.get() < 0) return bad(path, std::string("the key cannot be written: ") + std::strerror(errno));
  std::string text = key.text() + "\n";
  const bool written = write_all(file.get(), text);
  sodium_memzero(text.data(), text.size());
  const int error = written && link(own_name.c_str(), path.c_str()) == 0 ? 0 : errno;
  const bool unlinked = unlink(own_name.c_str()) == 0;
  if (error == EEXIST) return bad(path, "there is a key already");
  if (error != 0) return bad(path, std::string("the key cannot be written: ") + std::strerror(error));
  if (!unlinked) return bad(path, "a copy of the key is left in " + own_name + "; remove it");
  if (!sync_folder(path.parent_path()))
    return bad(path, std::string("the key may be lost at a power cut: its folder cannot be synced: ") +
                         std::strerror(errno));
  return {};
}

std::string environment(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

fs::path home_place() {
  if (const std::string config = environment("XDG_CONFIG_HOME"); !config.empty())
    return fs::path(config) / "strobe" / "lab.key";
  std::string home = environment("HOME");
  if (home.empty()) {
    const passwd* user = getpwuid(geteuid());
    if (user != nullptr && user->pw_dir != nullptr) home = user->pw_dir;
  }
  return home.empty() ? fs::path() : fs::path(home) / ".config" / "strobe" / "lab.key";
}

Result<FoundKey> with_path(Result<Key> key, const fs::path& path) {
  if (!key) return tl::unexpected(key.error());
  return FoundKey{*key, path, false};
}

Result<FoundKey> find_home_key() {
  const fs::path path = home_place();
  if (path.empty())
    return fail("this user has no home to keep the lab's key in; name one with --key-file FILE");
  std::error_code error;
  if (!fs::exists(fs::symlink_status(path, error))) {
    auto made = make_key_file(path);
    if (made) return made;
    if (!fs::exists(path, error))
      return fail(made.error().message + "; or name another with --key-file FILE");
  }
  return with_path(read_key_file(path), path);
}

}  // namespace

Result<Key> read_key_file(const fs::path& path) { return read_key(path, Keeper::user); }

Result<FoundKey> make_key_file(const fs::path& path) {
  std::error_code error;
  if (const fs::path folder = path.parent_path(); !folder.empty() && !fs::is_directory(folder, error)) {
    fs::create_directories(folder, error);
    if (error) return bad(path, "its folder cannot be made: " + error.message());
    // Nobody else may replace the key, but a rig file beside it is for others, such as the service's user.
    constexpr fs::perms kReadable =
        fs::perms::group_read | fs::perms::group_exec | fs::perms::others_read | fs::perms::others_exec;
    fs::permissions(folder, fs::perms::owner_all | kReadable, error);
  }
  const Key key = Key::random();
  if (auto written = write_new(key, path); !written) return tl::unexpected(written.error());
  return FoundKey{key, path, true};
}

Result<FoundKey> find_key(const KeyPlaces& places) {
  for (const std::string& named : {places.option, places.rig_file, environment("STROBE_KEY_FILE")}) {
    if (!named.empty()) return with_path(read_key_file(named), named);
  }
  if (const std::string credentials = environment("CREDENTIALS_DIRECTORY"); !credentials.empty()) {
    const fs::path path = fs::path(credentials) / "lab.key";
    if (access(credentials.c_str(), X_OK) != 0) {
      // Another key in its place would be a secret of this user alone.
      return bad(path, std::string("the key in $CREDENTIALS_DIRECTORY cannot be read: ") +
                           std::strerror(errno) + "; unset the variable, or name a key with --key-file FILE");
    }
    std::error_code error;
    if (fs::exists(fs::symlink_status(path, error))) return with_path(read_key(path, Keeper::systemd), path);
  }
  return find_home_key();
}

}  // namespace strobe::authentication
