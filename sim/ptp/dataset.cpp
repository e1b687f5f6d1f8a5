#include "sim/ptp/dataset.hpp"

#include <algorithm>

namespace strobe::sim::ptp {

namespace {

constexpr std::size_t kMaxCharacters = 254;

}  // namespace

DatasetWriter& DatasetWriter::put(std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  return *this;
}

DatasetWriter& DatasetWriter::text(std::string_view text) {
  text = text.substr(0, kMaxCharacters);
  if (text.empty()) return u8(0);
  return u8(text.size() + 1).name(text);
}

DatasetWriter& DatasetWriter::name(std::string_view text) {
  for (const char character : text) u16(static_cast<std::uint8_t>(character));
  return u16(0);
}

DatasetWriter& DatasetWriter::bytes(std::span<const std::uint8_t> bytes) {
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return *this;
}

DatasetWriter& DatasetWriter::array16(std::span<const std::uint16_t> values) {
  u32(values.size());
  for (const std::uint16_t value : values) u16(value);
  return *this;
}

DatasetWriter& DatasetWriter::array32(std::span<const std::uint32_t> values) {
  u32(values.size());
  for (const std::uint32_t value : values) u32(value);
  return *this;
}

std::uint64_t DatasetReader::take(std::size_t size) {
  if (bytes_.size() < size) {
    complete_ = false;
    bytes_ = {};
    return 0;
  }
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= std::uint64_t{bytes_[i]} << (8 * i);
  bytes_ = bytes_.subspan(size);
  return value;
}

std::string DatasetReader::text() {
  std::string text;
  for (int left = u8(); left > 0; --left) {
    const std::uint16_t character = u16();
    if (character != 0) text += character < 0x80 ? static_cast<char>(character) : '?';
  }
  return text;
}

}  // namespace strobe::sim::ptp
