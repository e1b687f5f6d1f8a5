#include "sim/fit/bounce.hpp"

#include <algorithm>
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

namespace {

/// Of mu, and of the stiffness and the offset: none may come out negative.
constexpr double kMaxFrictionSpread = 0.25;
constexpr double kMaxSpringSpread = 0.3;
constexpr int kSpreadRounds = 6;

/// Parameters of a shot's lift-off, in the order of field().
enum Parameter : std::size_t { kSpeed, kAngle, kSpin, kRestitution, kMu, kStiffness, kOffset };

double& field(Scene& scene, Parameter parameter) {
  double* const fields[] = {
      &scene.machine.speed_mps, &scene.machine.angle_rad,      &scene.machine.spin_radps, &scene.bounce.e,
      &scene.bounce.mu,         &scene.bounce.stiffness_ratio, &scene.bounce.offset_share};
  return *fields[parameter];
}

impact::Motion moved(Scene scene, Parameter parameter, double step) {
  field(scene, parameter) += step;
  const auto end = mean_lift_off(scene);
  return end ? end->rebound.lift_off : impact::Motion{};
}

/// Change of the mean lift-off with a parameter: the secant from one sd below to one above.
impact::Motion secant(const Scene& scene, Parameter parameter, double sd) {
  const impact::Motion a = moved(scene, parameter, sd);
  const impact::Motion b = moved(scene, parameter, -sd);
  const double step = 2.0 * sd;
  return {(a.vx_mps - b.vx_mps) / step, (a.vy_mps - b.vy_mps) / step, (a.omega_radps - b.omega_radps) / step};
}

void add(LiftOffVariances& sum, const Scene& scene, Parameter parameter, double sd) {
  if (!(sd > 0.0)) return;
  const impact::Motion change = secant(scene, parameter, sd);
  sum.vx += square(change.vx_mps * sd);
  sum.vy += square(change.vy_mps * sd);
  sum.spin += square(change.omega_radps * sd);
}

/// Standard deviations of the draw for more grip (of mu or of the stiffness) and of the offset.
struct Spreads {
  double grip_sd = 0.0;
  double offset_sd = 0.0;
  double correlation = 1.0;
  double misfit = std::numeric_limits<double>::infinity();
};

/// The search for spreads that make, with what is there already, the published variances.
struct Search {
  impact::Motion per_grip{};
  impact::Motion per_offset{};
  double grip = 1.0;  ///< means, which relative spreads refer to
  double offset = 1.0;
  double most_grip_sd = 0.0;
  double most_offset_sd = 0.0;
  LiftOffVariances there{};
  LiftOffVariances published{};
  double vx_excess = 1.0;  ///< over first order, where the response is not linear
  double spin_excess = 1.0;

  /// By grip and offset alone, to first order.
  LiftOffVariances first_order(const Spreads& s) const {
    const double o = s.correlation * s.offset_sd;
    return {square(per_grip.vx_mps * s.grip_sd + per_offset.vx_mps * o), 0.0,
            square(per_grip.omega_radps * s.grip_sd + per_offset.omega_radps * o)};
  }

  LiftOffVariances made(const Spreads& s) const {
    const LiftOffVariances v = first_order(s);
    return {there.vx + vx_excess * v.vx, there.vy, there.spin + spin_excess * v.spin};
  }

  /// Relative errors of the sds; of equal ones the smallest spreads.
  double misfit(const Spreads& s) const {
    const LiftOffVariances v = made(s);
    return square(std::sqrt(v.vx / published.vx) - 1.0) + square(std::sqrt(v.spin / published.spin) - 1.0) +
           kMinSpreads * (square(s.grip_sd / grip) + square(s.offset_sd / offset));
  }

  /// Successive grids, each around the best point of the one before.
  Spreads best(double correlation) const {
    Spreads best{.correlation = correlation};
    double width = 1.0;
    double grip_share = 0.5;
    double offset_share = 0.5;
    for (int zoom = 0; zoom < 12; ++zoom, width *= 0.4) {
      const double grip_middle = grip_share;
      const double offset_middle = offset_share;
      for (int i = -kGrid; i <= kGrid; ++i) {
        for (int j = -kGrid; j <= kGrid; ++j) {
          const double g = std::clamp(grip_middle + 0.5 * width * i / kGrid, 0.0, 1.0);
          const double o = std::clamp(offset_middle + 0.5 * width * j / kGrid, 0.0, 1.0);
          Spreads at{g * most_grip_sd, o * most_offset_sd, correlation};
          at.misfit = misfit(at);
          if (at.misfit >= best.misfit) continue;
          best = at;
          grip_share = g;
          offset_share = o;
        }
      }
    }
    return best;
  }

 private:
  static constexpr double kMinSpreads = 1e-6;
  static constexpr int kGrid = 12;
};

Spreads best_of(const Search& search) {
  const Spreads together = search.best(1.0);
  const Spreads against = search.best(-1.0);
  return against.misfit < together.misfit ? against : together;
}

/// Variances of the mean ball's lift-off under the joint draw of grip and offset, by Gauss and Hermite's rule
/// of seven points.
LiftOffVariances drawn(const Scene& scene, Parameter grip, const Spreads& spreads) {
  constexpr std::array<std::array<double, 2>, 7> rule{{{-3.7504397177257427, 5.4826885597221875e-4},
                                                       {-2.3667594107345412, 3.0757123967586498e-2},
                                                       {-1.1544053947399682, 0.24012317860501270},
                                                       {0.0, 0.45714285714285713},
                                                       {1.1544053947399682, 0.24012317860501270},
                                                       {2.3667594107345412, 3.0757123967586498e-2},
                                                       {3.7504397177257427, 5.4826885597221875e-4}}};
  impact::Motion mean;
  LiftOffVariances square_mean;
  for (const auto& [z, weight] : rule) {
    Scene at = scene;
    field(at, grip) = std::max(0.01, field(at, grip) + z * spreads.grip_sd);
    field(at, kOffset) =
        std::clamp(field(at, kOffset) + z * spreads.correlation * spreads.offset_sd, 0.0, 1.0);
    const impact::Motion lo = moved(at, kOffset, 0.0);
    mean.vx_mps += weight * lo.vx_mps;
    mean.omega_radps += weight * lo.omega_radps;
    square_mean.vx += weight * square(lo.vx_mps);
    square_mean.spin += weight * square(lo.omega_radps);
  }
  return {square_mean.vx - square(mean.vx_mps), 0.0, square_mean.spin - square(mean.omega_radps)};
}

/// Ratio to the first order, bounded.
double excess(double drawn, double first_order) {
  return first_order > 0.0 ? std::clamp(drawn / first_order, 0.1, 10.0) : 1.0;
}

struct Found {
  Spreads spreads;
  LiftOffVariances made;
};

/// With `grip` (mu or the stiffness) as what the draw moves. The secants are those of the spreads found.
Found spread_by(const Scene& scene, Parameter grip, const LiftOffVariances& there,
                const LiftOffVariances& published) {
  Scene at = scene;
  Search search{.grip = field(at, grip),
                .offset = scene.bounce.offset_share,
                .most_grip_sd = (grip == kMu ? kMaxFrictionSpread : kMaxSpringSpread) * field(at, grip),
                .most_offset_sd = kMaxSpringSpread * scene.bounce.offset_share,
                .there = there,
                .published = published};
  Spreads spreads{.grip_sd = 0.5 * search.most_grip_sd, .offset_sd = 0.5 * search.most_offset_sd};
  for (int round = 0; round < kSpreadRounds; ++round) {
    search.per_grip = secant(scene, grip, std::max(spreads.grip_sd, 1e-3 * search.grip));
    search.per_offset = secant(scene, kOffset, std::max(spreads.offset_sd, 1e-3 * search.offset));
    spreads = best_of(search);
    const LiftOffVariances linear = search.first_order(spreads);
    const LiftOffVariances truly = drawn(scene, grip, spreads);
    search.vx_excess = excess(truly.vx, linear.vx);
    search.spin_excess = excess(truly.spin, linear.spin);
  }
  spreads.misfit = search.misfit(spreads);
  return {spreads, search.made(spreads)};
}

}  // namespace

LiftOffVariances fit_spreads(Scene& scene, const LiftOffVariances& noise, const LiftOffVariances& published) {
  LiftOffVariances there = noise;
  add(there, scene, kSpeed, scene.machine.speed_sd_mps);
  add(there, scene, kAngle, scene.machine.angle_sd_rad);
  add(there, scene, kSpin, scene.machine.spin_sd_radps);
  BounceSettings& b = scene.bounce;
  b.e_sd =
      std::sqrt(std::max(0.0, published.vy - there.vy)) / std::abs(secant(scene, kRestitution, 1e-3).vy_mps);
  add(there, scene, kRestitution, b.e_sd);
  const Found by_mu = spread_by(scene, kMu, there, published);
  const Found by_stiffness = spread_by(scene, kStiffness, there, published);
  const bool mu = by_mu.spreads.misfit < by_stiffness.spreads.misfit;
  const Found& best = mu ? by_mu : by_stiffness;
  (mu ? b.mu_sd : b.stiffness_ratio_sd) = best.spreads.grip_sd;
  b.offset_share_sd = best.spreads.offset_sd;
  b.offset_grip_correlation = best.spreads.correlation;
  return best.made;
}

}  // namespace strobe::sim
