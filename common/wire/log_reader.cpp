#include "common/wire/log_reader.hpp"

#include <algorithm>
#include <array>

namespace strobe::wire {

namespace {

constexpr std::uint32_t kLongestLogChannel = 1000;  // as for LCM's own reader

std::uint32_t big_endian(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 |
         std::uint32_t{bytes[3]};
}

}  // namespace

bool LogReader::holds(std::int64_t offset, std::size_t size) const {
  return offset >= part_at_ && size <= part_.size() &&
         static_cast<std::size_t>(offset - part_at_) <= part_.size() - size;
}

/// Reads a part of the file that begins at the offset, unless these bytes are there already.
bool LogReader::hold(std::int64_t offset, std::size_t size) {
  if (holds(offset, size)) return true;
  part_.resize(std::max(size, kPart_bytes));
  file_.clear();
  file_.seekg(offset);
  file_.read(reinterpret_cast<char*>(part_.data()), static_cast<std::streamsize>(part_.size()));
  part_.resize(static_cast<std::size_t>(file_.gcount()));
  part_at_ = offset;
  bytes_read_ += file_.gcount();
  return holds(offset, size);
}

bool LogReader::read(std::int64_t offset, std::uint8_t* bytes, std::size_t size) {
  if (!hold(offset, size)) return false;
  std::copy_n(part_.begin() + (offset - part_at_), size, bytes);
  return true;
}

bool LogReader::read_record(std::int64_t offset, LogRecord& record) {
  std::array<std::uint8_t, kLogHeaderSize> header{};
  if (!read(offset, header.data(), header.size()) || big_endian(header.data()) != kLogSyncWord) return false;
  const std::uint32_t channel = big_endian(&header[20]), data = big_endian(&header[24]);
  if (channel == 0 || channel > kLongestLogChannel || data > kLargestMessage_bytes) return false;
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

LogReader::Step LogReader::advance(LogRecord& record) {
  if (read_record(at_, record)) return Step::record;
  const std::int64_t from = at_ + 1;
  if (!hold(from, kLogSync_bytes.size())) return Step::end;
  const auto same = [](std::uint8_t byte, char sync) { return byte == static_cast<std::uint8_t>(sync); };
  const auto hit = std::search(part_.begin() + (from - part_at_), part_.end(), kLogSync_bytes.begin(),
                               kLogSync_bytes.end(), same);
  // Without a hit: a sync word may lie across two parts.
  at_ = part_at_ +
        (hit != part_.end() ? hit - part_.begin() : std::ssize(part_) - std::ssize(kLogSync_bytes) + 1);
  return Step::searching;
}

bool LogReader::next(LogRecord& record) {
  const std::int64_t from = at_;
  Step step = advance(record);
  while (step == Step::searching) step = advance(record);
  if (step == Step::end) at_ = from;
  return step == Step::record;
}

}  // namespace strobe::wire
