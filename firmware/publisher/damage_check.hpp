// Looks through a whole journal for damage between its records, in bounded steps. Not real-time; one thread's.
#pragma once

#include "common/wire/log_reader.hpp"

namespace strobe::firmware {

class DamageCheck {
 public:
  DamageCheck(const std::filesystem::path& path, std::int64_t boot_id) : log_(path), boot_id_(boot_id) {}

  /// Reads at most one record and wire::LogReader::kPart_bytes of the file. Returns false at its end.
  bool step();
  /// What was found so far, in words of at most 160 characters; empty: nothing. What follows the last whole
  /// record is not counted.
  std::string finding() const;
  /// From the file so far.
  std::int64_t bytes_read() const { return log_.bytes_read(); }

 private:
  wire::LogReader log_;
  wire::LogRecord record_;
  std::int64_t boot_id_;
  std::int64_t whole_end_ = 0;  ///< where the last whole record ends
  std::int64_t damaged_ = 0;    ///< bytes between whole records
};

}  // namespace strobe::firmware
