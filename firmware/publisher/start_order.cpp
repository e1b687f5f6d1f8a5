#include "firmware/publisher/start_order.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <string>

#include "firmware/publisher/journal.hpp"

namespace strobe::firmware {

namespace {

constexpr const char* kFile = "starts";
constexpr std::int64_t kTail_bytes = std::int64_t{64} << 10;

}  // namespace

StartOrder::StartOrder(const std::filesystem::path& dir) {
  std::ifstream file(dir / kFile, std::ios::binary | std::ios::ate);
  if (!file) return;
  file.seekg(std::max<std::int64_t>(file.tellg() - kTail_bytes, 0));
  for (std::string line; std::getline(file, line);) {
    std::uint64_t boot_id = 0;
    const char* const end = line.data() + line.size();
    const auto [after, error] = std::from_chars(line.data(), end, boot_id, 16);
    if (line.size() == 16 && error == std::errc() && after == end)
      positions_[static_cast<std::int64_t>(boot_id)] = positions_.size() + 1;
  }
}

std::size_t StartOrder::position(std::int64_t boot_id) const {
  const auto found = positions_.find(boot_id);
  return found == positions_.end() ? 0 : found->second;
}

Result<void> StartOrder::add(const std::filesystem::path& dir, std::int64_t boot_id) {
  const std::filesystem::path path = dir / kFile;
  const auto failed = [&path] {
    return fail(path.string() + ": this start cannot be listed: " + std::strerror(errno));
  };
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (fd < 0) return failed();
  const std::string line = "\n" + boot_in_hex(boot_id);  // so that what was torn is a line of its own
  errno = ENOSPC;                                        // of a write that was cut short
  const bool done = write(fd, line.data(), line.size()) == std::ssize(line) && fsync(fd) == 0;
  const int cause = errno;
  close(fd);
  errno = cause;
  if (!done) return failed();
  return {};
}

}  // namespace strobe::firmware
