// What the simulated chip recorded of its lines: the judge of what the firmware did, independent of what it
// says.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace strobe::hil {

inline constexpr std::int64_t kMs = 1'000'000;  ///< in nanoseconds

struct LineChange {
  std::int64_t time_ns = 0;  ///< CLOCK_MONOTONIC
  std::string line;
  int level = 0;
  std::string cause;  ///< set, request, release, drive
};

class LineChanges {
 public:
  explicit LineChanges(const std::filesystem::path& csv);
  explicit LineChanges(std::vector<LineChange> changes);

  const std::vector<LineChange>& all() const { return changes_; }

  /// How often a line went to 1 in [from, to].
  int rises(const std::string& line, std::int64_t from_ns = INT64_MIN, std::int64_t to_ns = INT64_MAX) const;

  /// Level after all changes up to and including this instant; 0 before the first.
  int level_at(const std::string& line, std::int64_t time_ns) const;

  /// From this instant on the outputs all stay at 0. The later of `from_ns` and the last change that made an
  /// output inactive; INT64_MAX if one is active in the end.
  std::int64_t outputs_safe_from(std::int64_t from_ns) const;

  /// The same within [from, to]: the instant from which on no output is active until `to`; INT64_MAX if one
  /// is at `to`.
  std::int64_t inactive_from(std::int64_t from_ns, std::int64_t to_ns) const;

 private:
  std::vector<LineChange> changes_;
};

inline const std::vector<std::string> kOutputs{"STROBE_A", "STROBE_B", "SHUTTER", "TRIGGER"};

}  // namespace strobe::hil
