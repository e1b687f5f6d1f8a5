#include "common/reduction/propagate.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "common/flight/vertical.hpp"
#include "common/reduction/flight_effects.hpp"
#include "common/reduction/group_rows.hpp"
#include "common/reduction/surface_crossing.hpp"
#include "common/statistics/distributions.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

/// What of a number is a quotient, and by what it is divided.
struct Quotient {
  Number of;
  Number divisor;
};

/// A quotient is not linear in its divisor: of one within some 20 sd of zero the first order's interval is
/// too narrow where the divisor came out too large. The quotients that the measurements do not exclude at k
/// sd (Fieller, J. R. Statist. Soc. B 16, 1954) reach k times this many sd to their far side, for a divisor
/// with the relative sd `share`. Returns nullopt if they have no end: the divisor may be zero.
std::optional<double> fieller_reach(double k, double share, double correlation) {
  const double reach = k * share;
  const double left = 1.0 - reach * reach;
  if (!(left > 0.0)) return std::nullopt;
  const double along = reach * std::abs(correlation);
  return (along + std::sqrt(left + along * along)) / left;
}

/// Noise of so many sd must leave a quotient within so many of its stated sd.
constexpr double kNoise_sd = 4.0;
constexpr double kHeld_sd = 5.0;

/// Standard deviations of a number with known gradient.
class Uncertainty {
 public:
  explicit Uncertainty(const ShotFit& fit) : fit_(fit) {
    for (const VarianceComponent& component : fit.variance_components)
      any_estimated_ = any_estimated_ || component.used;
    if (any_estimated_) rows_ = group_rows(fit);
    split_air();
    // The ball's diameter enters the fit through those of the images only: they say scale * diameter.
    double pull = 0.0;
    for (const Observation& o : fit.observations.images) {
      if (!o.use_diameter) continue;
      const double sd = fit.observations.diameter_sd(o);
      pull += fit.observations.ball_diameter_m / (sd * sd);
    }
    JointVector scale{};
    scale[kScale] = pull;
    by_images_ = fit.joint.factor.unknowns(fit.joint.factor.whitened(scale));
  }

  struct Statistical {
    double sd = 0.0;
    std::optional<double> degrees_of_freedom;  ///< absent: infinitely many
  };

  /// Returns nullopt if the number depends on a variance component that no residuals tell.
  std::optional<Statistical> statistical(const Number& q) const {
    const JointVector y = fit_.joint.factor.whitened(joint_gradient(q));
    const double variance =
        dot(y, y) + spin_covariance(q, q, &SpinFit::variance) + std::max(by_air(q, q, statistical_air_), 0.0);
    if (!any_estimated_ || variance == 0.0) return Statistical{std::sqrt(variance), {}};
    const auto parts = variance_shares(q, y);
    double uncertain = 0.0;  // sum of (estimated share)^2 / its degrees of freedom
    double fewest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < kNoiseGroupCount; ++i) {
      const VarianceComponent& component = fit_.variance_components[i];
      if (!component.used) continue;
      const double share = std::min(parts[i] / variance, 1.0);
      if (!(share > 1e-9)) continue;
      if (component.degrees_of_freedom == 0.0) return std::nullopt;
      uncertain += share * share / component.degrees_of_freedom;
      fewest = std::min(fewest, component.degrees_of_freedom);
    }
    const double sd = std::sqrt(variance);
    if (!(uncertain > 0.0)) return Statistical{sd, {}};
    const double freedom = std::max(1.0 / uncertain, fewest);  // Welch-Satterthwaite
    return Statistical{sd * statistics::student_t_sigma(freedom), freedom};
  }

  /// Of the ball's diameter and of what all images' are off alike, where that is stated, and of the air.
  std::optional<double> systematic(const Number& q) const {
    const double by_decay = q.grad[kDecay] * fit_.spin_decay_sd_per_m;
    const double air = std::sqrt(std::max(by_air(q, q, air_tolerance_), 0.0) + by_decay * by_decay);
    const Observations& seen = fit_.observations;
    if (!seen.ball_diameter_sd_m && !seen.shared_diameter_sd_m)
      return air > 0.0 ? std::optional(air) : std::nullopt;
    const double by_images = dot(joint_gradient(q), by_images_);
    const double by_ball = q.grad[kDiameter] - fit_.joint.unknowns[kScale] * by_images;
    return std::hypot(by_ball * seen.ball_diameter_sd_m.value_or(0.0),
                      by_images * seen.shared_diameter_sd_m.value_or(0.0), air);
  }

  /// What a quotient's variance lacks to the first order, see fieller_reach(). Returns nullopt if the divisor
  /// may be zero. `whole_sd`: of the number that it is part of.
  std::optional<double> lacking_variance(const Quotient& q, double whole_sd) const {
    const auto sd = statistical(q.of), divisor_sd = statistical(q.divisor);
    const double negligible_sd = kNegligibleShareOfSd * whole_sd;
    if (!sd || !divisor_sd || !(divisor_sd->sd > 0.0) || !(sd->sd > negligible_sd)) return 0.0;
    const double both = std::sqrt(covariance(q.of, q.of)) * std::sqrt(covariance(q.divisor, q.divisor));
    if (!(both > 0.0)) return 0.0;
    const double correlation = std::min(std::abs(covariance(q.of, q.divisor)) / both, 1.0);
    const auto reach = fieller_reach(kNoise_sd, divisor_sd->sd / std::abs(q.divisor.value), correlation);
    if (!reach) return std::nullopt;
    const double factor = std::max(kNoise_sd / kHeld_sd * *reach, 1.0);
    // From nothing on, where the part begins to count.
    return (factor - 1.0) * (factor + 1.0) * (sd->sd - negligible_sd) * (sd->sd + negligible_sd);
  }

  double covariance(const Number& a, const Number& b) const {
    return dot(fit_.joint.factor.whitened(joint_gradient(a)), fit_.joint.factor.whitened(joint_gradient(b))) +
           spin_covariance(a, b, &SpinFit::variance) + by_air(a, b, statistical_air_);
  }

 private:
  static JointVector joint_gradient(const Number& q) {
    JointVector g;
    std::copy_n(q.grad.begin(), kJointCount, g.begin());
    return g;
  }

  double spin_covariance(const Number& a, const Number& b, double SpinFit::*which) const {
    double sum = 0.0;
    for (std::size_t leg = 0; leg < 2; ++leg) {
      if (fit_.spin[leg]) sum += a.grad[kSpin[leg]] * b.grad[kSpin[leg]] * (*fit_.spin[leg]).*which;
    }
    return sum;
  }

  /// What the images' noise makes of the air's errors, and the range of a lift that is open; or what is left
  /// of the tolerances of drag and lift.
  static double by_air(const Number& a, const Number& b, const AirCovariance& covariance) {
    double sum = 0.0;
    for (std::size_t p = 0; p < kAirErrorCount; ++p) {
      for (std::size_t q = 0; q < kAirErrorCount; ++q)
        sum += a.grad[kAir + p] * b.grad[kAir + q] * covariance[p][q];
    }
    return sum;
  }

  void split_air() {
    const AirFit& air = fit_.air_fit;
    for (std::size_t p = 0; p < kAirErrorCount; ++p) {
      for (std::size_t q = 0; q < kAirErrorCount; ++q) {
        const bool open = air.prior[p].open && air.prior[q].open;
        const bool known = !air.prior[p].open && !air.prior[q].open;
        statistical_air_[p][q] = air.by_noise[p][q] + (open ? air.by_prior[p][q] : 0.0);
        air_tolerance_[p][q] = known ? air.by_prior[p][q] : 0.0;
      }
    }
  }

  /// The part of the variance that each variance component accounts for: the number moves by the sum of
  /// (row . u) error, u being the covariance times its gradient.
  std::array<double, kNoiseGroupCount> variance_shares(const Number& q, const JointVector& y) const {
    std::array<double, kNoiseGroupCount> parts{};
    const JointVector u = fit_.joint.factor.unknowns(y);
    for (const GroupRow& row : rows_) {
      const double by_error = row * u;
      parts[static_cast<std::size_t>(row.noise)] += by_error * by_error;
    }
    parts[static_cast<std::size_t>(NoiseGroup::equator)] =
        spin_covariance(q, q, &SpinFit::estimated_variance);
    return parts;
  }

  const ShotFit& fit_;
  std::vector<GroupRow> rows_;
  JointVector by_images_{};  ///< by what all their diameters are larger
  AirCovariance statistical_air_{};
  AirCovariance air_tolerance_{};
  bool any_estimated_ = false;
};

/// Symmetric and positive semidefinite, to rounding: Cholesky's pivots of the correlations, each raised by
/// the tolerance, are positive. For assertions.
[[maybe_unused]] bool is_covariance(const PrimaryCovariance& covariance) {
  constexpr double kTolerance = 1e-9;
  PrimaryCovariance root{};
  for (std::size_t i = 0; i < kPrimaryCount; ++i) {
    for (std::size_t k = 0; k <= i; ++k) {
      const double both = covariance[i][k];
      if (!std::isfinite(both) || !std::isfinite(covariance[i][i])) return true;  // of frames of no ball
      if (both != covariance[k][i] || covariance[i][i] < 0.0) return false;
      const double scale = std::sqrt(covariance[i][i]) * std::sqrt(covariance[k][k]);
      double left = scale > 0.0 ? both / scale : both;  // variances span twenty orders
      if (i == k) left += kTolerance;
      for (std::size_t j = 0; j < k; ++j) left -= root[i][j] * root[k][j];
      if (i == k && !(left > 0.0)) return false;
      root[i][k] = i == k ? std::sqrt(left) : left / root[k][k];
    }
  }
  return true;
}

class Propagation {
 public:
  Propagation(const ShotFit& fit, const PropagationOptions& options, Readout& readout)
      : fit_(fit), readout_(readout), uncertainty_(fit), widened_(options.widened) {
    if (options.by_time) time_response_ = time_response(fit);
    readout.by_time.assign(time_response_.size(), {});
  }

  void legs() {
    for (std::size_t leg = 0; leg < (fit_.observations.has_surface() ? 2 : 1); ++leg) {
      crossing_[leg] = crossing(fit_, leg);
      const bool spin_lacks = fit_.observations.line_drawn && !fit_.spin[leg];
      if (!fit_.joint.legs[leg].fitted || spin_lacks) readout_.flags.set(Flag::too_few_images);
      if (fit_.joint.legs[leg].fitted && !crossing_[leg]) readout_.flags.set(Flag::degenerate_geometry);
      if (fit_.spin[leg]) omega_[leg] = spin_at_surface(leg);
    }
    leg(0, {Quantity::theta_in_deg, Quantity::vx_td_mps, Quantity::vy_td_mps, Quantity::v_td_mps,
            Quantity::omega_td_radps});
    leg(1, {Quantity::theta_out_deg, Quantity::vx_lo_mps, Quantity::vy_lo_mps, Quantity::v_lo_mps,
            Quantity::omega_lo_radps});
    if (crossing_[1] && omega_[1])
      put(Quantity::slip_lo_mps, crossing_[1]->vx_mps + radius(fit_) * *omega_[1]);
  }

  void impact(std::optional<double> temperature_c) {
    if (!crossing_[0] || !crossing_[1]) return;
    const SurfaceCrossing& td = *crossing_[0];
    const SurfaceCrossing& lo = *crossing_[1];
    const Number e = -lo.vy_mps / td.vy_mps;
    const Number lost = td.vx_mps - lo.vx_mps;
    const Number bounce = lo.vy_mps - td.vy_mps;
    const Number mu = lost / bounce;
    put(Quantity::e, e, {{e, td.vy_mps}});
    put(Quantity::mu, mu, {{mu, bounce}});
    const Number dwell = lo.time_s - td.time_s;
    if (dwell.value > 0.0) {
      put(Quantity::dwell_time_ms, dwell * 1e3);
      put(Quantity::dwell_distance_cm, (lo.x_m - td.x_m) * 1e2);
    } else {
      readout_.flags.set(Flag::degenerate_geometry);
    }
    drop(td, lo);
    if (temperature_c)
      put(Quantity::court_pace, court_pace_rating(e, mu, *temperature_c),
          {{e * kRestitutionPoints, td.vy_mps}, {mu * kFrictionPoints, bounce}});
    if (omega_[0]) regime(lost, td.vx_mps + radius(fit_) * *omega_[0]);
    const auto& v_td = readout_.value[Quantity::v_td_mps];
    const auto& theta_in = readout_.value[Quantity::theta_in_deg];
    readout_.court_pace_conforming = temperature_c && omega_[0] && v_td && theta_in &&
                                     meets_court_pace_limits(*v_td, *theta_in, omega_[0]->value);
  }

  /// Of the numbers that the others follow from, if all of them are there.
  void covariance() {
    if (!crossing_[0] || !crossing_[1] || !omega_[0] || !omega_[1]) return;
    const std::array<Number, kPrimaryCount> primary{
        crossing_[0]->vx_mps, crossing_[0]->vy_mps, *omega_[0], crossing_[0]->time_s,
        crossing_[1]->vx_mps, crossing_[1]->vy_mps, *omega_[1], crossing_[1]->time_s};
    constexpr std::array kTold{Quantity::vx_td_mps, Quantity::vy_td_mps, Quantity::vx_lo_mps,
                               Quantity::vy_lo_mps, Quantity::dwell_time_ms};
    readout_.covariance.reset();
    if (widened_ && std::ranges::any_of(kTold, [&](Quantity q) { return !readout_.value[q]; })) return;
    PrimaryCovariance& matrix = readout_.covariance.emplace();
    for (std::size_t i = 0; i < kPrimaryCount; ++i) {
      // Sums in another order would differ by rounding.
      for (std::size_t k = 0; k <= i; ++k)
        matrix[i][k] = matrix[k][i] = uncertainty_.covariance(primary[i], primary[k]);
    }
    assert(is_covariance(matrix));
  }

  Crossings crossings() const {
    Crossings at;
    for (std::size_t leg = 0; leg < 2; ++leg) {
      if (crossing_[leg]) at[leg] = crossing_[leg]->time_s.value;
    }
    return at;
  }

 private:
  /// From the instant that the spin was fitted for, by the decay over the path between.
  Number spin_at_surface(std::size_t leg) const {
    const SpinFit& spin = *fit_.spin[leg];
    const Number mean = Number::variable(spin.omega_radps, kSpin[leg]);
    if (!crossing_[leg]) return mean;
    const double origin_s = fit_.joint.legs[leg].origin_s;
    const double crossing_s = crossing_[leg]->time_s.value;
    const flight::Flight flight = flight_of(fit_, leg);
    const Eigen::Vector2d d =
        flight.position_at(spin.time_s - origin_s) - flight.position_at(crossing_s - origin_s);
    constexpr double kMaxDisplacement_m = 100.0;  // a frame of no ball may have any, and overflow
    if (!(std::abs(d.x()) < kMaxDisplacement_m && std::abs(d.y()) < kMaxDisplacement_m)) return mean;
    const double displacement_m = std::copysign(std::hypot(d.x(), d.y()), spin.time_s - crossing_s);
    Number at_surface = mean * std::exp(fit_.spin_decay_per_m * displacement_m);
    at_surface.grad[kDecay] = at_surface.value * displacement_m;
    return at_surface;
  }

  struct LegQuantities {
    Quantity theta, vx, vy, v, omega;
  };

  void leg(std::size_t leg, const LegQuantities& names) {
    if (const auto& at = crossing_[leg]) {
      const Number theta = atan2(at->vy_mps, at->vx_mps) * degrees(1.0);
      const Number v = hypot(at->vx_mps, at->vy_mps);
      put(names.theta, theta, {{theta, v}});
      put(names.vx, at->vx_mps);
      put(names.vy, at->vy_mps);
      put(names.v, v);
    }
    if (omega_[leg]) put(names.omega, *omega_[leg]);
  }

  /// What of a number hangs on the instants, which are heights over velocities, and the number's own
  /// quotients. Returns nullopt if one of their divisors may be zero.
  std::optional<double> lacking_variance(const Number& number, double sd,
                                         std::initializer_list<Quotient> own) const {
    double sum = 0.0;
    const auto add = [&](const Quotient& q) {
      const auto variance = uncertainty_.lacking_variance(q, sd);
      sum += variance.value_or(0.0);
      return variance.has_value();
    };
    for (std::size_t leg = 0; leg < 2; ++leg) {
      const auto& at = crossing_[leg];
      const double by_instant = number.grad[kInstant[leg]];
      if (at && by_instant != 0.0 && !add({at->time_s * by_instant, at->vy_mps})) return std::nullopt;
    }
    for (const Quotient& q : own)
      if (!add(q)) return std::nullopt;
    return sum;
  }

  void put(Quantity quantity, const Number& number, std::initializer_list<Quotient> quotients = {}) {
    if (!std::isfinite(number.value)) return;
    readout_.value[quantity] = number.value;
    if (const auto statistical = uncertainty_.statistical(number)) {
      const auto lacking = widened_ ? lacking_variance(number, statistical->sd, quotients) : 0.0;
      if (!lacking) return withhold(quantity);
      readout_.sd[quantity] = std::hypot(statistical->sd, std::sqrt(*lacking));
      readout_.degrees_of_freedom[quantity] = statistical->degrees_of_freedom;
    }
    readout_.sd_systematic[quantity] = uncertainty_.systematic(number);
    for (std::size_t i = 0; i < time_response_.size(); ++i)
      readout_.by_time[i][static_cast<std::size_t>(quantity)] = dot(number.grad, time_response_[i]);
  }

  void drop(const SurfaceCrossing& td, const SurfaceCrossing& lo) {
    readout_.drop.reset();
    const Eigen::Vector2d& gravity = fit_.observations.gravity_mps2;
    const auto upright = [](double along, double across) {
      return std::abs(along) <= kDropSlope * std::abs(across);
    };
    if (!upright(gravity.x(), gravity.y()) || !upright(td.vx_mps.value, td.vy_mps.value) ||
        !upright(lo.vx_mps.value, lo.vy_mps.value))
      return;
    const double g = gravity.norm();
    const Number drag = drag_per_m();
    const auto fall = flight::fall_m(-td.vy_mps.value, drag.value, g);
    const auto rise = flight::rise_m(lo.vy_mps.value, drag.value, g);
    if (!std::isfinite(fall.value) || !std::isfinite(rise.value)) return;
    const auto told = [&](const flight::VerticalNumber& height, const Number& speed) {
      const Number number = chain(speed, drag, height.value, height.by_input, height.by_drag_per_m);
      const auto statistical = uncertainty_.statistical(number);
      // A drag that does not matter to the velocities may matter to a flight that goes on.
      const double by_drag =
          fit_.effects.drag && fit_.joint.air_used
              ? 0.0
              : height.by_drag_per_m * drag.value * fit_.observations.air_law.drag_share_sd();
      return DerivedNumber{height.value, statistical ? statistical->sd : 0.0,
                           std::hypot(uncertainty_.systematic(number).value_or(0.0), by_drag)};
    };
    readout_.drop = Drop{told(fall, -td.vy_mps), told(rise, lo.vy_mps)};
  }

  /// As fitted, or as assumed where it is not.
  Number drag_per_m() const {
    const Observations& all = fit_.observations;
    const double assumed = flight::aerodynamics(all.ball, all.air_density_kgpm3, {}, all.air_law).drag_per_m;
    Number drag(assumed * (1.0 + fit_.air_fit.value[kDragError]));
    drag.grad[kAir + kDragError] = assumed;
    drag.grad[kDiameter] = 2.0 * drag.value / all.ball_diameter_m;
    return drag;
  }

  void withhold(Quantity quantity) {
    readout_.flags.set(Flag::degenerate_geometry);
    for (Quantities* of :
         {&readout_.value, &readout_.sd, &readout_.sd_systematic, &readout_.degrees_of_freedom})
      (*of)[quantity].reset();
    for (TimeDerivatives& of_image : readout_.by_time) of_image[static_cast<std::size_t>(quantity)] = 0.0;
  }

  /// What is missing of the change of vx that ends the slip, |slip| alpha / (1 + alpha), against its own sd:
  /// that of the measurements, of the ball's diameter, and of its alpha.
  void regime(const Number& lost, const Number& slip) {
    const double alpha = fit_.observations.ball.alpha;
    const Number missing = short_of_rolling_mps(slip, lost, alpha);
    if (missing.value <= 0.0) {
      readout_.regime = Regime::grips;
      return;
    }
    const auto statistical = uncertainty_.statistical(missing);
    const double by_alpha =
        std::abs(slip.value) / ((1.0 + alpha) * (1.0 + alpha)) * fit_.observations.alpha_sd;
    const double tolerance = std::hypot(by_alpha, uncertainty_.systematic(missing).value_or(0.0));
    const bool certain = statistical && missing.value > 2.0 * std::hypot(statistical->sd, tolerance);
    readout_.regime = certain ? Regime::slides : Regime::unclear;
  }

  const ShotFit& fit_;
  Readout& readout_;
  Uncertainty uncertainty_;
  bool widened_;
  std::vector<Response> time_response_;  ///< empty unless asked for
  std::array<std::optional<SurfaceCrossing>, 2> crossing_;
  std::array<std::optional<Number>, 2> omega_;
};

}  // namespace

Crossings propagate(const ShotFit& fit, const PropagationOptions& options, Readout& readout) {
  Propagation propagation(fit, options, readout);
  propagation.legs();
  propagation.impact(options.temperature_c);
  if (options.covariance) propagation.covariance();
  return propagation.crossings();
}

bool may_lack_variance(const Numbers& numbers) {
  // fieller_reach() is at most 1 / (1 - k share).
  constexpr double kShare = (1.0 - kNoise_sd / kHeld_sd) / kNoise_sd;
  constexpr std::array kDivisors{Quantity::v_td_mps, Quantity::vy_td_mps, Quantity::v_lo_mps,
                                 Quantity::vy_lo_mps};
  return std::ranges::any_of(kDivisors, [&](Quantity q) {
    return numbers.sd[q] && !(*numbers.sd[q] <= kShare * std::abs(*numbers.value[q]));
  });
}

}  // namespace strobe::reduction
