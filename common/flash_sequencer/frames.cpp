#include <algorithm>

#include "common/flash_sequencer/protocol.hpp"

namespace strobe::flash_sequencer {
namespace {

/// The CRC of each byte, least significant bit first.
constexpr std::array<std::uint32_t, 256> byte_crcs() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    table[byte] = crc;
  }
  return table;
}
constexpr auto kByteCrcs = byte_crcs();

constexpr std::size_t kHead = 2;  ///< kind and number
constexpr std::size_t kCrc = 4;

std::uint32_t read_crc(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < kCrc; ++i) crc |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
  return crc;
}

/// In place: bytes without zeroes into what they stand for. Its size; 0 if a block's length points outside.
std::size_t unstuff(std::span<std::uint8_t> bytes) {
  std::size_t written = 0;
  for (std::size_t read = 0; read < bytes.size();) {
    const std::size_t block = bytes[read];
    if (read + block > bytes.size()) return 0;
    for (std::size_t i = 1; i < block; ++i) bytes[written++] = bytes[read + i];
    read += block;
    if (block < 0xFF && read < bytes.size()) bytes[written++] = 0;
  }
  return written;
}

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  std::uint32_t crc = ~before;
  for (const std::uint8_t byte : bytes) crc = kByteCrcs[(crc ^ byte) & 0xFFU] ^ (crc >> 8);
  return ~crc;
}

std::size_t encode(const Frame& frame, std::span<std::uint8_t, kMaxFrame> wire) {
  std::array<std::uint8_t, kHead + kMaxBody + kCrc> plain;
  plain[0] = frame.kind;
  plain[1] = frame.number;
  const auto body = frame.bytes();
  std::copy(body.begin(), body.end(), plain.begin() + kHead);
  const std::size_t covered = kHead + body.size();
  const std::uint32_t crc = crc32(std::span(plain).first(covered));
  for (std::size_t i = 0; i < kCrc; ++i) plain[covered + i] = static_cast<std::uint8_t>(crc >> (8 * i));

  // A frame is shorter than 254 bytes, so that no block is ever full.
  static_assert(plain.size() < 254 && plain.size() + 2 == kMaxFrame);
  std::size_t written = 1, block_at = 0;
  for (const std::uint8_t byte : std::span(plain).first(covered + kCrc)) {
    if (byte != 0) {
      wire[written++] = byte;
      continue;
    }
    wire[block_at] = static_cast<std::uint8_t>(written - block_at);
    block_at = written++;
  }
  wire[block_at] = static_cast<std::uint8_t>(written - block_at);
  wire[written++] = 0;
  return written;
}

const Frame* Decoder::take(std::uint8_t byte) {
  if (byte != 0) {
    too_long_ = too_long_ || size_ == raw_.size();
    if (!too_long_) raw_[size_++] = byte;
    return nullptr;
  }
  const auto raw = std::span(raw_).first(size_);
  const bool nothing = size_ == 0;
  const bool whole = !too_long_;
  size_ = 0;
  too_long_ = false;
  if (nothing) return nullptr;  // zeroes in a row
  const std::size_t size = whole ? unstuff(raw) : 0;
  if (size < kHead + kCrc || size > kHead + kMaxBody + kCrc ||
      crc32(raw.first(size - kCrc)) != read_crc(raw.subspan(size - kCrc))) {
    ++damaged_;
    return nullptr;
  }
  frame_.kind = raw[0];
  frame_.number = raw[1];
  frame_.size = static_cast<std::uint8_t>(size - kHead - kCrc);
  std::copy_n(raw.begin() + kHead, frame_.size, frame_.body.begin());
  return &frame_;
}

}  // namespace strobe::flash_sequencer
