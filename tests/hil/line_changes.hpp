// What the simulated chip recorded of its lines: the judge of what the firmware did, independent of what it
// says.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/gpiochip/chip.hpp"
#include "tests/support/process.hpp"

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

/// Watches a bench's lines while it works, so that a test can act at an instant of a shot.
class LineWatcher {
 public:
  /// Sees changes from now on. std::runtime_error if there is no chip.
  explicit LineWatcher(const std::filesystem::path& chip_dir);

  /// Waits for a line to reach a level; the instant of the change, or 0 when the limit passed. Limits are of the
  /// rig's time.
  std::int64_t wait_for(const std::string& line, int level, std::chrono::milliseconds limit);

  /// The instant of the n-th change (from 1) of a line to a level, from now on; 0 when the limit passed.
  std::int64_t wait_for_nth(const std::string& line, int level, int n, std::chrono::milliseconds limit);

  /// The same as wait_for() while a command runs; 0 at once when the command has ended without it.
  std::int64_t wait_for(const std::string& line, int level, testing::Process& command);

  /// Whether the condition comes to hold within the limit, however long a busy machine takes for that; given up where
  /// the rig's time stands still.
  bool wait_until(const std::function<bool()>& condition, std::chrono::milliseconds limit) const;

  /// Drives an input with a stamp of now.
  void drive(const std::string& line, int level);

  /// Breaks an input's wire, with a stamp of now; drive() mends it.
  void open_wire(const std::string& line);

  /// As if somebody pulled the chip's cable.
  std::int64_t now_ns() const { return to_ns(chip_.now()); }  ///< by the clock that changes are stamped by
  void unplug();

  sim::LineState state(const std::string& line) const;

  /// Rig time stands still, however long the test takes for what it does meanwhile; and goes on.
  void hold_time() { chip_.hold_time(); }
  void release_time() { chip_.begin_time(); }

 private:
  std::uint32_t number(const std::string& line) const;

  sim::Chip chip_;
  sim::ChangeCursor cursor_;
};

}  // namespace strobe::hil
