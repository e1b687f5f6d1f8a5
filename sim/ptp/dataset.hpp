// Datasets of PTP (ISO 15740:2013, clause 5.3): little-endian numbers, arrays with their length before them,
// strings of at most 254 UTF-16 characters with their count before and a zero behind them. Values;
// thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "sim/ptp/codes.hpp"

namespace strobe::sim::ptp {

class DatasetWriter {
 public:
  DatasetWriter& u8(std::uint64_t value) { return put(value, 1); }
  DatasetWriter& u16(std::uint64_t value) { return put(value, 2); }
  DatasetWriter& u32(std::uint64_t value) { return put(value, 4); }
  DatasetWriter& u64(std::uint64_t value) { return put(value, 8); }
  /// Of ASCII.
  DatasetWriter& text(std::string_view text);
  DatasetWriter& bytes(std::span<const std::uint8_t> bytes);
  DatasetWriter& array16(std::span<const std::uint16_t> values);
  DatasetWriter& array32(std::span<const std::uint32_t> values);
  /// Characters of UTF-16 with a zero behind them, without a count: PTP/IP's names.
  DatasetWriter& name(std::string_view text);

  Bytes take() { return std::move(bytes_); }

 private:
  DatasetWriter& put(std::uint64_t value, int size);

  Bytes bytes_;
};

/// Reads in order; what is not there any more reads as zero, and is remembered.
class DatasetReader {
 public:
  explicit DatasetReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(take(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(take(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(take(4)); }
  std::uint64_t u64() { return take(8); }
  /// Characters beyond ASCII as '?'.
  std::string text();

  std::span<const std::uint8_t> rest() const { return bytes_; }
  bool complete() const { return complete_; }

 private:
  std::uint64_t take(std::size_t size);

  std::span<const std::uint8_t> bytes_;
  bool complete_ = true;
};

}  // namespace strobe::sim::ptp
