// What a published bounce says of angular momentum about the contact point, whatever the friction was and whether the
// ball gripped:
//   alpha·R·(omega_LO - omega_TD) = (vx_LO - vx_TD) - g_x·dwell + d·J/R,
// with g_x the weight's acceleration along the surface and d the normal force's offset ahead of the centre. Either alpha
// follows, if there is no offset, or the offset, with the ball's alpha. Pure; thread-safe; copies names.
#pragma once

#include <optional>
#include <span>

#include "common/impact/fit/rolling_friction.hpp"
#include "host/bounces/prediction.hpp"

namespace strobe::bounces {

struct Balance {
  published::Measured alpha;       ///< without an offset
  published::Measured offset_m;    ///< with the ball's alpha; sd statistical
  double offset_sd_alpha_m = 0.0;  ///< systematic, from the ball's alpha
  double slip_lo_mps = 0.0;        ///< vx + R·omega at lift-off
  double e_x = 0.0;                ///< -slip_LO/slip_TD; negative where the ball slides to the end
};

/// With the weight along the surface taken off, or without. nullopt where vx at lift-off is not published, or where the
/// spin did not change.
std::optional<Balance> balance_of(const Case& bounce, bool with_weight);

/// One alpha for all, weighted by the statistical sds; chi-square of its residuals.
struct MeanAlpha {
  published::Measured alpha;
  double chi_square = 0.0;
  int count = 0;
};

/// Precondition: sds above 0.
MeanAlpha mean_of(std::span<const published::Measured> alphas);

}  // namespace strobe::bounces
