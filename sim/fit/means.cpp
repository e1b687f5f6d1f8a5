#include "sim/fit/means.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "common/impact/fit/bounded_least_squares.hpp"

namespace strobe::sim {

namespace {

/// One coefficient of the contact, and how far (as a logarithm) conditions are taken to be from the fit to
/// all.
struct Coefficient {
  double BounceSettings::*field;
  double typical;
  double spread;
};

constexpr impact::ContactCoefficients kCommon{};
constexpr std::array<Coefficient, 4> kCoefficients{{
    {&BounceSettings::mu, kCommon.mu, 0.1},
    {&BounceSettings::stiffness_ratio, kCommon.stiffness_ratio, 0.5},
    {&BounceSettings::damping_ratio, kCommon.damping_ratio, 0.5},
    {&BounceSettings::offset_share, kCommon.offset_share, 0.5},
}};
/// A residual of this share of the published sd weighs as much as one spread of a coefficient.
constexpr double kAsGoodAsReached = 0.01;
/// Largest distance of a condition from the others: a larger misfit is the model's, or the table's.
constexpr double kMaxSpreads = 2.5;
constexpr int kRounds = 12;

void set_coefficients(BounceSettings& b, const Eigen::VectorXd& spreads) {
  for (std::size_t i = 0; i < kCoefficients.size(); ++i) {
    const Coefficient& c = kCoefficients[i];
    b.*c.field = c.typical * std::exp(c.spread * spreads[static_cast<Eigen::Index>(i)]);
  }
}

/// What is left of lift-off, then the coefficients' distances from the common ones.
Eigen::VectorXd residuals(Scene& scene, const thesis::Condition& c, const Eigen::VectorXd& spreads) {
  set_coefficients(scene.bounce, spreads);
  Eigen::VectorXd r(2 + spreads.size());
  const auto end = mean_lift_off(scene);
  if (!end) return Eigen::VectorXd::Constant(r.size(), std::numeric_limits<double>::infinity());
  const impact::Motion& lo = end->rebound.lift_off;
  r[0] = (lo.vx_mps - c.vx_lo_mps.mean) / (kAsGoodAsReached * c.vx_lo_mps.sd);
  r[1] = (lo.omega_radps - c.omega_lo_radps.mean) / (kAsGoodAsReached * c.omega_lo_radps.sd);
  r.tail(spreads.size()) = spreads;
  return r;
}

/// The weight lessens the rebound and lengthens the contact a little: e and dwell time are set so that what
/// comes out is what was measured. True if they were that already.
Result<bool> correct_for_weight(Scene& scene, const thesis::Condition& c) {
  return mean_lift_off(scene).map([&](const LiftOff& end) {
    const double e = c.vy_lo_mps.mean / end.rebound.lift_off.vy_mps;
    const double dwell = c.dwell_time_ms.mean * 1e-3 / end.dwell_s;
    scene.bounce.e *= e;
    scene.bounce.dwell_s *= dwell;
    return std::abs(e - 1.0) < 1e-10 && std::abs(dwell - 1.0) < 1e-10;
  });
}

}  // namespace

Result<LiftOff> mean_lift_off(const Scene& scene) {
  // By the reference: along flat valleys of the fit a file's last digits would follow those of the method.
  return ode_lift_off(scene, draw_shot_conditions(without_spread(scene), 1, 1), Model::full(),
                      impact::ContactMethod::dormand_prince);
}

Result<void> fit_coefficients(Scene& scene, const thesis::Condition& condition) {
  scene.bounce.e = condition.vy_lo_mps.mean / -condition.vy_td_mps.mean;
  scene.bounce.e_speed_mps = -condition.vy_td_mps.mean;
  scene.bounce.dwell_s = condition.dwell_time_ms.mean * 1e-3;
  Eigen::VectorXd spreads = Eigen::VectorXd::Zero(kCoefficients.size());
  const impact::LeastSquaresProblem problem{
      .residuals = [&](const Eigen::VectorXd& at) { return residuals(scene, condition, at); },
      .lower = Eigen::VectorXd::Constant(spreads.size(), -kMaxSpreads),
      .upper = Eigen::VectorXd::Constant(spreads.size(), kMaxSpreads),
      .scale = Eigen::VectorXd::Constant(spreads.size(), 0.1),
      .difference_step = 1e-4,
      .function_tolerance = 1e-10};
  for (int round = 0; round < kRounds; ++round) {
    spreads = impact::levenberg_marquardt(problem, spreads).parameters;
    set_coefficients(scene.bounce, spreads);
    const auto settled = correct_for_weight(scene, condition);
    if (!settled) return tl::unexpected(settled.error());
    if (*settled) break;
  }
  return {};
}

}  // namespace strobe::sim
