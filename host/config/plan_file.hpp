// The shot that the operator wants: the rig file's [plan] table or a PLAN.toml with the same keys at top
// level. Values only, no I/O; thread-safe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/config/toml_reader.hpp"
#include "common/result.hpp"
#include "common/shot/shot_plan.hpp"

namespace strobe::host {

/// Of a train without a code of its own. coded: by intervals that name its flashes, see
/// host/assembly/coded_spacing.hpp, which knows what images can tell.
enum class Spacing { even, coded };

/// What a plan file says, to the nanosecond: a shot with an even train, and how that train is coded.
struct PlanFile {
  /// Period 100 us to 1 s, exposure 1 ms to 1 min, gate delay up to 10 s, gated flashes 1 to 100,000; no
  /// code.
  ShotPlan even{.period = milliseconds{3}, .exposure = milliseconds{500}};
  Spacing spacing = Spacing::coded;  ///< even where a period alone, or a code, was given
  /// Of balls that are dropped: of their lowest point above the surface, 0.01 to 20. Their images lie on one
  /// line, so that the period is chosen for them (host/assembly/drop_plan.hpp) unless it is stated. 0 (key
  /// absent): thrown.
  double drop_height_m = 0.0;
  bool period_stated = false;  ///< beside drop_height_m, or over it
  /// Intervals between one flash and the next, repeated over the train; as long as a period may be. Empty:
  /// all are the period.
  std::vector<Duration> intervals;
  // Numbers of flashes within the train, from 0, counted before any is left out; ascending, each at most
  // once.
  std::vector<int> omit;    ///< are left out
  std::vector<int> only_a;  ///< of lamp A alone
  std::vector<int> only_b;

  bool coded() const { return !intervals.empty() || !omit.empty() || !only_a.empty() || !only_b.empty(); }
  /// With the coded train, if it is one; Spacing::coded counts as even. Valid: a plan as it was read.
  ShotPlan shot() const;
  bool operator==(const PlanFile&) const = default;
};

/// Reads the keys that the table has, keeps `defaults` for the others and reports what does not fit together.
PlanFile read_plan_table(config::TomlTable table, const PlanFile& defaults);

/// A PLAN.toml. Fails with "FILE:LINE: key: what".
Result<PlanFile> read_plan(std::string_view text, const std::string& file_name, const PlanFile& defaults);

/// The plan as a PLAN.toml that read_plan() reads back to the same plan.
std::string plan_to_toml(const PlanFile& plan);

}  // namespace strobe::host
