#include "host/session/csv_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

namespace strobe::host {
namespace {

Error errno_error(const std::filesystem::path& path) { return {path.string() + ": " + std::strerror(errno)}; }

bool write_all(int fd, const std::string& text) {
  const ssize_t written = ::write(fd, text.data(), text.size());
  return written == static_cast<ssize_t>(text.size());
}

std::ptrdiff_t columns(const std::string& header) {
  return 1 + std::count(header.begin(), header.end(), ',');
}

}  // namespace

Result<CsvFile> CsvFile::open(const std::filesystem::path& path, const std::string& header,
                              const std::string& earlier) {
  std::string first;
  {
    std::ifstream existing(path);
    if (existing) std::getline(existing, first);
  }
  if (!first.empty() && first != header && first != earlier) {
    return fail(path.string() + ":1: another version's columns; use another session folder");
  }
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (fd < 0) return tl::unexpected(errno_error(path));
  CsvFile csv(path, fd, first.empty() ? 0 : columns(header) - columns(first));
  if (first.empty()) {
    if (!write_all(fd, header + "\n")) return tl::unexpected(errno_error(path));
    return csv;
  }
  char last = '\n';
  struct stat status {};
  if (::fstat(fd, &status) == 0 && status.st_size > 0 && ::pread(fd, &last, 1, status.st_size - 1) == 1 &&
      last != '\n') {
    if (!write_all(fd, "\n")) return tl::unexpected(errno_error(path));
  }
  return csv;
}

CsvFile::CsvFile(CsvFile&& other) noexcept
    : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)), left_out_(other.left_out_) {}

CsvFile::~CsvFile() {
  if (fd_ >= 0) ::close(fd_);
}

Result<void> CsvFile::append(const std::string& line) {
  std::string kept = line;
  for (std::ptrdiff_t i = 0; i < left_out_; ++i) kept.resize(kept.rfind(','));
  if (!write_all(fd_, kept + "\n")) return tl::unexpected(errno_error(path_));
  return {};
}

}  // namespace strobe::host
