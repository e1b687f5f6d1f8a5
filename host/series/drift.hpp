// The witnesses of a series on their control charts, an alarm where one leaves control, and the one thing
// that explains what all charts show. Deterministic; not thread-safe; allocates.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/series/control_chart.hpp"
#include "host/series/witness.hpp"

namespace strobe::host {

/// Sound shots between two false alarms of all charts together, in the mean: as many as of one chart of
/// Shewhart's with limits of three sds, or more.
inline constexpr double kShotsPerFalseAlarm = 370.0;

enum class Culprit {
  scale,   ///< the camera's: zoom, focus, distance
  ball,    ///< its diameter
  clock,   ///< the rig's clock against this computer's
  tilt,    ///< of the camera or the surface
  lamp_a,  //
  lamp_b,  //
  air,     ///< what drags and lifts
  lens,    ///< paths that were straight are not
};
inline constexpr std::array<std::string_view, 8> kCulpritNames{"scale",  "ball",   "clock", "tilt",
                                                               "lamp_a", "lamp_b", "air",   "lens"};
inline constexpr std::size_t kCulpritCount = kCulpritNames.size();
constexpr std::string_view name(Culprit c) { return kCulpritNames[static_cast<std::size_t>(c)]; }

struct DriftAlarm {
  Witness chart = Witness::gravity_mps2;
  std::string shot;   ///< at which it was told
  std::string since;  ///< after the CUSUM's last zero
};

/// By how much a number has changed since an alarm's first shot, against what was before.
struct WitnessShift {
  Witness witness = Witness::gravity_mps2;
  reduction::Estimate before, change;
};

struct DriftVerdict {
  std::vector<DriftAlarm> alarms;  ///< the first of each chart, in the order of the shots
  std::vector<WitnessShift> shifts;
  /// Best first; several cannot be told apart; none: no single thing explains the shifts.
  std::vector<Culprit> culprits;
};

class WitnessCharts {
 public:
  WitnessCharts();

  /// Shots in the order of firing. Returns the charts that alarm now.
  std::vector<Witness> add(const std::string& shot, const ShotWitnesses& witnesses);

  /// Null: no shot had the number.
  const ControlChart* chart(Witness w) const;
  const std::string& shot(std::size_t index) const { return shots_[index]; }
  const std::vector<std::string>& shots() const { return shots_; }
  /// Returns nullopt if no chart has alarmed.
  std::optional<DriftVerdict> verdict() const;

 private:
  std::vector<WitnessShift> shifts_since(std::size_t shot) const;

  double limit_;
  std::array<std::optional<ControlChart>, kWitnessCount> charts_;
  std::vector<std::string> shots_;
  bool calibrated_ = false;
};

/// Which single thing explains the shifts: least chi squared with its size free, 9 more for each further free
/// number; those within 9 of the best cannot be told apart; one that chance lets fit as badly once in 10,000
/// explains nothing. A shift that a thing does not cause is zero, as far as its sd tells.
/// Source: likelihood ratio, e.g. Koch, Parameter Estimation and Hypothesis Testing, 4.2.
std::vector<Culprit> culprits(std::span<const WitnessShift> shifts, bool calibrated);

WitnessCharts charts_of(std::span<const Shot> shots);

}  // namespace strobe::host
