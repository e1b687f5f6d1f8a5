#include "firmware/publisher/log_reader.hpp"

#include <algorithm>
#include <array>

namespace strobe::firmware {

namespace {

constexpr std::uint32_t kLongestChannel = 1000;
constexpr std::size_t kPart = std::size_t{16} << 10;  // of the file, read at once
constexpr std::uint32_t kLargestMessage = std::uint32_t{16} << 20;

std::uint32_t big_endian(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 |
         std::uint32_t{bytes[3]};
}

}  // namespace

void LogReader::fill(std::int64_t offset, std::size_t size) {
  part_.resize(size);
  file_.clear();
  file_.seekg(offset);
  file_.read(reinterpret_cast<char*>(part_.data()), static_cast<std::streamsize>(size));
  part_.resize(static_cast<std::size_t>(file_.gcount()));
  part_at_ = offset;
}

bool LogReader::read(std::int64_t offset, std::uint8_t* bytes, std::size_t size) {
  const auto holds = [&] {
    return offset >= part_at_ && size <= part_.size() &&
           static_cast<std::size_t>(offset - part_at_) <= part_.size() - size;
  };
  if (!holds()) fill(offset, std::max(size, kPart));
  if (!holds()) return false;
  std::copy_n(part_.begin() + (offset - part_at_), size, bytes);
  return true;
}

bool LogReader::read_record(std::int64_t offset, LogRecord& record) {
  std::array<std::uint8_t, kLogHeaderSize> header{};
  if (!read(offset, header.data(), header.size()) || big_endian(header.data()) != kLogSyncWord) return false;
  const std::uint32_t channel = big_endian(&header[20]), data = big_endian(&header[24]);
  if (channel == 0 || channel > kLongestChannel || data > kLargestMessage) return false;
  std::vector<std::uint8_t> body(std::size_t{channel} + data);
  if (!read(offset + static_cast<std::int64_t>(header.size()), body.data(), body.size())) return false;
  record.offset = offset;
  record.wall_us = static_cast<std::int64_t>(std::uint64_t{big_endian(&header[12])} << 32 |
                                             std::uint64_t{big_endian(&header[16])});
  record.channel.assign(body.begin(), body.begin() + channel);
  record.bytes.assign(body.begin() + channel, body.end());
  at_ = offset + static_cast<std::int64_t>(header.size() + body.size());
  return true;
}

bool LogReader::find_sync(std::int64_t from, std::int64_t& found) {
  constexpr std::array<std::uint8_t, 4> kSync{0xED, 0xA1, 0xDA, 0x01};
  std::vector<std::uint8_t> part(65536);
  for (std::int64_t offset = from;;) {
    file_.clear();
    file_.seekg(offset);
    file_.read(reinterpret_cast<char*>(part.data()), static_cast<std::streamsize>(part.size()));
    const auto got = static_cast<std::ptrdiff_t>(file_.gcount());
    if (got < static_cast<std::ptrdiff_t>(kSync.size())) return false;
    const auto hit = std::search(part.begin(), part.begin() + got, kSync.begin(), kSync.end());
    if (hit != part.begin() + got) {
      found = offset + (hit - part.begin());
      return true;
    }
    offset += got - static_cast<std::ptrdiff_t>(kSync.size()) + 1;  // a sync word may lie across two parts
  }
}

bool LogReader::next(LogRecord& record) {
  if (read_record(at_, record)) return true;
  for (std::int64_t candidate = at_; find_sync(candidate, candidate); ++candidate) {
    if (read_record(candidate, record)) return true;
  }
  return false;
}

}  // namespace strobe::firmware
