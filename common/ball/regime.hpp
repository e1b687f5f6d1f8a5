// What the contact point did during an impact, and how it is told from the velocities: the one definition of
// readouts, predictions and fits. Plain values and pure functions; thread-safe, real-time safe.
#pragma once

#include <cmath>
#include <string_view>

namespace strobe {

enum class Regime {
  slides,  ///< friction was at its limit throughout
  grips,   ///< the contact point came to a stop before lift-off
  unclear  ///< a measurement does not tell; never a model's
};

constexpr std::string_view name(Regime regime) {
  return regime == Regime::slides ? "slides" : regime == Regime::grips ? "grips" : "unclear";
}

/// What the change of vx is short of rolling: friction that ends the slip vx + R·omega of touchdown changes
/// vx by |slip|·alpha/(1 + alpha). A ball that changes it by less slid throughout; m/s. Of numbers, or of
/// those that carry their derivatives along.
template <typename Number>
constexpr Number short_of_rolling_mps(const Number& slip_td_mps, const Number& change_of_vx_mps,
                                      double alpha) {
  using std::abs;
  return abs(slip_td_mps) * (alpha / (1.0 + alpha)) - abs(change_of_vx_mps);
}

/// The regime of velocities that are exact but for rounding.
constexpr Regime regime_of_exact(double slip_td_mps, double change_of_vx_mps, double alpha) {
  constexpr double kRounding = 1e-12;
  const double missing = short_of_rolling_mps(slip_td_mps, change_of_vx_mps, alpha);
  const double needed = missing + std::abs(change_of_vx_mps);
  return missing > kRounding * needed ? Regime::slides : Regime::grips;
}

}  // namespace strobe
