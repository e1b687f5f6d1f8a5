// What each lamp lights on the photograph: dry shots of lamp A, of lamp B and of both, and of both at the
// beginning and at the end of the exposure, all exposed for as long. Only what is in the view decides: a
// sensor sees a lamp that the camera does not. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include "common/result.hpp"
#include "host/commission/record/step_result.hpp"
#include "host/config/rig_file.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::commission {

/// One dry shot's photograph.
struct LitPhotograph {
  digitize::Photograph photograph;
  int flashes = 0;
};
struct LampPhotographs {
  LitPhotograph of_a, of_b, of_both;
  LitPhotograph early, late;  ///< both lamps, at the exposure's beginning and end
};

struct LampLight {
  double a = 0.0, b = 0.0;  ///< of one flash, over what saturates, mean of the pixels that are lit
  double dark = 0.0;        ///< of the exposure without any flash
  /// Light of both that is not that of A and of B, as a share of it: 0 where light adds up and the file's
  /// numbers are proportional to it, or where the shutter is not open from the first flash to the last.
  double excess = 0.0;
  double early = 1.0, late = 1.0;  ///< light of those flashes over that of the better of the two trains
  double lit_share = 0.0;          ///< of the pixels: bright enough, and not saturated
};

/// Fails with one line if the photographs differ in size, or hardly anything in the view reflects.
Result<LampLight> measure_lamp_light(const LampPhotographs& photographs);

/// Light of a hundred flashes that vary by 5 % is known to 0.5 %, of A + B - both to 0.9 %.
inline constexpr double kMaxExcess = 0.05;
/// Of the short trains' light: 16 flashes that vary by 5 % scatter by 1.3 %; a flash that the shutter cuts
/// off is 6 %.
inline constexpr double kMinEdgeLight = 0.85;

StepResult judge_light(const LampLight& light, const host::CommissionTable& limits);
/// Whether the shutter is open from the first flash to the last.
StepResult judge_exposure_window(const LampLight& light);

}  // namespace strobe::commission
