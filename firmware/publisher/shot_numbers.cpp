#include "firmware/publisher/shot_numbers.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>

#include "common/config/files.hpp"

namespace strobe::firmware {

namespace {

constexpr const char* kName = "shot-numbers";
constexpr const char* kNewName = "shot-numbers.new";
constexpr std::int32_t kHighest = 2'000'000'000;

/// Empty: done, on the disk.
std::string write_synced(const std::filesystem::path& path, const std::string& text) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return std::strerror(errno);
  const bool done = config::write_all(fd, text) && fsync(fd) == 0;
  const std::string fault = done ? "" : std::strerror(errno);
  close(fd);
  return fault;
}

}  // namespace

std::optional<std::int32_t> ShotNumbers::read(const std::filesystem::path& dir) {
  std::ifstream file(dir / kName, std::ios::binary);
  std::array<char, 16> text{};
  file.read(text.data(), text.size());
  const char* const end = text.data() + file.gcount();
  std::int32_t number = -1;
  const auto [after, error] = std::from_chars(text.data(), end, number);
  const bool whole = error == std::errc() && after + 1 == end && *after == '\n';
  if (!whole || number < 0 || number > kHighest) return std::nullopt;
  return number;
}

ShotNumbers::ShotNumbers(std::filesystem::path dir, std::int32_t last_in_journals) : dir_(std::move(dir)) {
  const auto stored = read(dir_);
  const std::int32_t left_out = !stored && last_in_journals > 0 ? kAtOnce : 0;
  last_before_ = std::max(stored.value_or(0), std::min(last_in_journals, kHighest) + left_out);
  limit_ = last_before_;
}

Result<void> ShotNumbers::write(std::int32_t highest) const {
  const auto failed = [this](const std::string& cause) {
    return fail((dir_ / kName).string() + ": no number can be set aside for a shot: " + cause);
  };
  if (highest > kHighest) return failed("there are none left");
  std::error_code error;
  std::filesystem::create_directories(dir_, error);
  if (error) return failed(error.message());
  if (const std::string fault = write_synced(dir_ / kNewName, std::to_string(highest) + "\n"); !fault.empty())
    return failed(fault);
  if (std::rename((dir_ / kNewName).c_str(), (dir_ / kName).c_str()) != 0)
    return failed(std::strerror(errno));
  if (!config::sync_folder(dir_)) return failed(std::strerror(errno));
  return {};
}

Result<void> ShotNumbers::set_aside(std::int32_t last_used) {
  assert(last_used >= 0 && last_used <= limit_);
  if (limit_ - last_used >= kAtOnce / 2) return {};
  if (auto written = write(last_used + kAtOnce); !written) return written;
  limit_ = last_used + kAtOnce;
  return {};
}

Result<void> ShotNumbers::give_back(std::int32_t last_used) {
  assert(last_used >= 0 && last_used <= limit_);
  if (read(dir_) != limit_) return {};  // another start has set its own aside since
  limit_ = last_used;
  return write(last_used);
}

}  // namespace strobe::firmware
