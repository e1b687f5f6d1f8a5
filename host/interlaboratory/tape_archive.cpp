#include "host/interlaboratory/tape_archive.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <string_view>

#include "common/config/files.hpp"

namespace strobe::interlaboratory {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxNameLength = 1000;
constexpr std::size_t kPiece = std::size_t{1} << 18;

struct EndsArchive {
  void operator()(archive* a) const { archive_free(a); }
};
using Archive = std::unique_ptr<archive, EndsArchive>;

/// A file that goes, unless it is renamed.
struct OpenFile {
  fs::path path;
  int fd = -1;
  OpenFile(fs::path its_path, int flags) : path(std::move(its_path)) {
    fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | flags, 0644);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (fd >= 0) close(fd);
  }
};

std::string system_reason() { return std::strerror(errno); }

std::string reason(archive* a) {
  const char* text = archive_error_string(a);
  return text ? text : "unknown reason";
}

/// Its begin; the bytes follow.
bool begin_entry(archive* to, const std::string& name, std::uintmax_t size, std::int64_t mtime_s) {
  const std::unique_ptr<archive_entry, void (*)(archive_entry*)> entry(archive_entry_new(),
                                                                       archive_entry_free);
  archive_entry_set_pathname(entry.get(), name.c_str());
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_entry_set_perm(entry.get(), 0644);
  archive_entry_set_size(entry.get(), static_cast<la_int64_t>(size));
  archive_entry_set_mtime(entry.get(), static_cast<time_t>(mtime_s), 0);
  return archive_write_header(to, entry.get()) == ARCHIVE_OK;
}

bool put(archive* to, std::string_view bytes) {
  return archive_write_data(to, bytes.data(), bytes.size()) == static_cast<la_ssize_t>(bytes.size());
}

Result<void> pack_file(archive* to, const PackedFile& file, std::int64_t mtime_s, const std::string& name) {
  const auto not_written = [&] { return fail(name + ": cannot be written: " + reason(to)); };
  if (file.from.empty()) {
    if (!begin_entry(to, file.name, file.text.size(), mtime_s) || !put(to, file.text)) return not_written();
    return {};
  }
  std::ifstream in(file.from, std::ios::binary);
  std::error_code error;
  std::uintmax_t left = fs::file_size(file.from, error);
  if (!in || error) return fail(file.from.string() + ": cannot be read");
  if (!begin_entry(to, file.name, left, mtime_s)) return not_written();
  std::vector<char> piece(kPiece);
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())), in.gcount() > 0) {
    const auto read = static_cast<std::size_t>(in.gcount());
    if (read > left) break;
    left -= read;
    if (!put(to, {piece.data(), read})) return not_written();
  }
  if (left > 0 || in.gcount() > 0) return fail(file.from.string() + ": changes while it is read");
  return {};
}

/// The next entry's bytes, as a new file.
Result<void> unpack_file(archive* from, const fs::path& path, const std::string& where) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  const OpenFile file(path, O_EXCL);
  if (file.fd < 0) return fail(where + ": " + (errno == EEXIST ? "stands there twice" : system_reason()));
  std::vector<char> piece(kPiece);
  for (la_ssize_t read = 0; (read = archive_read_data(from, piece.data(), piece.size())) != 0;) {
    if (read < 0) return fail(where + ": " + reason(from));
    if (!config::write_all(file.fd, {piece.data(), static_cast<std::size_t>(read)}))
      return fail(where + ": cannot be unpacked: " + system_reason());
  }
  return {};
}

/// What forbids the entry, or nothing.
std::string objection(archive_entry* entry, const std::string& name, std::uintmax_t left) {
  if (!is_safe_name(name)) return "its name leads out of the folder, or is none";
  if (archive_entry_hardlink(entry) || archive_entry_symlink(entry)) return "is a link";
  const auto type = archive_entry_filetype(entry);
  if (type != AE_IFREG && type != AE_IFDIR) return "is no file";
  if (archive_entry_size(entry) < 0 || static_cast<std::uintmax_t>(archive_entry_size(entry)) > left)
    return "is larger than the archive";
  return "";
}

}  // namespace

Result<void> pack(const fs::path& archive, const std::vector<PackedFile>& files, std::int64_t mtime_s) {
  const OpenFile unfinished(archive.string() + ".unfinished", O_TRUNC);
  const auto problem = [&](const std::string& why) {
    std::error_code ignored;
    fs::remove(unfinished.path, ignored);
    return fail(why);
  };
  const std::string begin = archive.string() + ": cannot be written: ";
  if (unfinished.fd < 0) return fail(begin + system_reason());
  const Archive writer(archive_write_new());
  archive_write_set_format_gnutar(writer.get());  // long names and files, bytes of names as they are
  if (archive_write_open_fd(writer.get(), unfinished.fd) != ARCHIVE_OK)
    return problem(begin + reason(writer.get()));
  for (const PackedFile& file : files)
    if (const auto packed = pack_file(writer.get(), file, mtime_s, archive.string()); !packed)
      return problem(packed.error().message);
  if (archive_write_close(writer.get()) != ARCHIVE_OK) return problem(begin + reason(writer.get()));
  if (fsync(unfinished.fd) != 0 || std::rename(unfinished.path.c_str(), archive.c_str()) != 0)
    return problem(begin + system_reason());
  return {};
}

bool is_safe_name(const std::string& name) {
  if (name.empty() || name.size() > kMaxNameLength || name.front() == '/' || name.back() == '/') return false;
  if (std::ranges::any_of(name, [](char c) { return (c >= 0 && c < 0x20) || c == 0x7F || c == '\\'; }))
    return false;
  for (std::size_t begin = 0, end = 0; begin < name.size(); begin = end + 1) {
    end = std::min(name.find('/', begin), name.size());
    const std::string_view part = std::string_view(name).substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") return false;
  }
  return true;
}

Result<std::vector<std::string>> unpack(const fs::path& archive, const fs::path& into) {
  std::error_code error;
  std::uintmax_t left = fs::file_size(archive, error);
  if (error) return fail(archive.string() + ": " + error.message());
  const Archive reader(archive_read_new());
  archive_read_support_format_tar(reader.get());
  if (archive_read_open_filename(reader.get(), archive.c_str(), 10'240) != ARCHIVE_OK)
    return fail(archive.string() + ": is no tar archive: " + reason(reader.get()));
  std::vector<std::string> names;
  archive_entry* entry = nullptr;
  for (int status = 0; (status = archive_read_next_header(reader.get(), &entry)) != ARCHIVE_EOF;) {
    if (status < ARCHIVE_WARN)
      return fail(archive.string() + (names.empty() ? ": is no tar archive: " : ": damaged: ") +
                  reason(reader.get()));
    const char* told = archive_entry_pathname(entry);
    std::string name = told ? told : "";
    const bool is_folder = archive_entry_filetype(entry) == AE_IFDIR;
    if (is_folder && name.ends_with('/')) name.pop_back();
    const std::string where = archive.string() + ": " + fmt::format("\"{}\"", name);
    if (const std::string why = objection(entry, name, left); !why.empty()) return fail(where + ": " + why);
    if (is_folder) continue;
    left -= static_cast<std::uintmax_t>(archive_entry_size(entry));
    if (const auto done = unpack_file(reader.get(), into / name, where); !done)
      return tl::unexpected(done.error());
    names.push_back(name);
  }
  if (names.empty()) return fail(archive.string() + ": holds nothing");
  return names;
}

}  // namespace strobe::interlaboratory
