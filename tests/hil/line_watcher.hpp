// Watches a bench's lines while it works, so that a test can act at an instant of a shot.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "sim/gpiochip/chip.hpp"
#include "tests/support/process.hpp"

namespace strobe::hil {

class LineWatcher {
 public:
  /// Sees changes from now on. std::runtime_error if there is no chip.
  explicit LineWatcher(const std::filesystem::path& chip_dir);

  /// Waits for a line to reach a level; the instant of the change, or 0 when the limit passed.
  std::int64_t wait_for(const std::string& line, int level, std::chrono::milliseconds limit);

  /// The instant of the n-th change (from 1) of a line to a level, from now on; 0 when the limit passed.
  std::int64_t wait_for_nth(const std::string& line, int level, int n, std::chrono::milliseconds limit);

  /// The same as wait_for() while a command runs; 0 at once when the command has ended without it.
  std::int64_t wait_for(const std::string& line, int level, testing::Process& command);

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
