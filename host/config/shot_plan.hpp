// The shot that the operator wants: the rig file's [plan] table or a PLAN.toml with the same keys at top
// level. Values only, no I/O; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/toml_reader.hpp"
#include "common/result.hpp"

namespace strobe::host {

enum class Train { free, gated };

enum class FlashLamps { a = 1, b = 2, both = 3 };  ///< values are those of coded_flash_t

struct CodedFlash {
  double offset_us = 0.0;  ///< from the train's first instant
  FlashLamps lamps = FlashLamps::both;

  bool operator==(const CodedFlash&) const = default;
};
inline constexpr std::size_t kMaxCodedFlashes = 1024;

struct ShotPlan {
  Train train = Train::free;
  double period_us = 3000.0;           ///< 100 to 1e6; 3000 is 20,000 flashes a minute
  double shutter_open_ms = 500.0;      ///< 1 to 60,000
  double gate_delay_ms = 0.0;          ///< gated: 0 to 10,000, gate edge to first flash
  int flash_count = 0;                 ///< gated: 1 to 100,000; free: 0
  std::optional<double> impact_at_ms;  ///< free: opening of the shutter to touchdown; absent: the rig file's
  /// Intervals between one flash and the next, repeated over the train; each 100 to 1e6. Empty: all are
  /// period_us.
  std::vector<double> intervals_us;
  // Numbers of flashes within the train, from 0, counted before any is left out; ascending, each at most
  // once.
  std::vector<int> omit;    ///< are left out
  std::vector<int> only_a;  ///< of lamp A alone
  std::vector<int> only_b;

  bool coded() const { return !intervals_us.empty() || !omit.empty() || !only_a.empty() || !only_b.empty(); }
  bool operator==(const ShotPlan&) const = default;
};

/// Reads the keys that the table has, keeps `defaults` for the others and reports what does not fit together.
ShotPlan read_plan_table(config::TomlTable table, const ShotPlan& defaults);

/// The flashes of a coded plan, in order of time; empty for an even train.
std::vector<CodedFlash> train_code(const ShotPlan& plan);

/// A PLAN.toml. Fails with "FILE:LINE: key: what".
Result<ShotPlan> read_plan(std::string_view text, const std::string& file_name, const ShotPlan& defaults);

/// The plan as a PLAN.toml that read_plan() reads back to the same plan.
std::string plan_to_toml(const ShotPlan& plan);

}  // namespace strobe::host
