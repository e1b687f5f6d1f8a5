#include "common/reduction/propagate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/reduction/court_pace.hpp"
#include "common/reduction/dual.hpp"
#include "common/reduction/student_t.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

// Variables of the derivatives: the joint fit's unknowns, both spins, the ball's diameter.
constexpr std::size_t kSpin[2] = {kJointCount, kJointCount + 1};
constexpr std::size_t kDiameter = kJointCount + 2;
using Number = Dual<kJointCount + 3>;

/// A leg where its centre is one radius above the surface, in the surface's axes.
struct Crossing {
  Number time_s;
  Number x_m;
  Number vx_mps;
  Number vy_mps;
};

Number unknown(const ShotFit& fit, int index) {
  return Number::variable(fit.joint.unknowns[index], static_cast<std::size_t>(index));
}

Number radius(const ShotFit& fit) {
  return Number::variable(fit.observations.ball_diameter_m, kDiameter) * 0.5;
}

/// Height over the surface less a radius is c + b t + g t^2 / 2. The speed at its zero is the root of
/// b^2 - 2 g c, downwards before the impact; t = -2 c / (b + speed) loses no digits where the fall is slight.
std::optional<Crossing> crossing(const ShotFit& fit, std::size_t leg) {
  const LegTime& times = fit.joint.legs[leg];
  if (!times.fitted) return std::nullopt;
  const int k = kLegStart[leg];
  const Number tilt = unknown(fit, kTilt);
  const Number cos = chain(tilt, std::cos(tilt.value), -std::sin(tilt.value));
  const Number sin = chain(tilt, std::sin(tilt.value), std::cos(tilt.value));
  const Number scale = unknown(fit, kScale);
  const Number per_second = scale * times.span_s;
  const Number px = unknown(fit, k);
  const Number py = unknown(fit, k + 1);
  const Number ux = unknown(fit, k + 2);
  const Number uy = unknown(fit, k + 3);
  const Number height = (cos * py - sin * px - unknown(fit, kHeight)) / scale - radius(fit);
  const Number x = (cos * px + sin * py) / scale;
  const Number vx = (cos * ux + sin * uy) / per_second;
  const Number vy = (cos * uy - sin * ux) / per_second;
  const double g = fit.joint.gravity_mps2.y;
  const double sign = leg == 0 ? -1.0 : 1.0;
  const double edge = (leg == 0 ? times.last_s : times.first_s) - times.origin_s;
  const bool towards_surface = sign * (vy.value + g * edge) > 0.0;
  const double square = vy.value * vy.value - 2.0 * g * height.value;
  if (!towards_surface || !(square > 0.0)) return std::nullopt;
  const Number speed = sign * sqrt(vy * vy - 2.0 * g * height);
  // Of the two equal forms the one whose denominator does not cancel.
  const bool alike = vy.value * speed.value > 0.0;
  const Number t = alike ? -2.0 * height / (vy + speed) : (speed - vy) / g;
  const double gx = fit.joint.gravity_mps2.x;
  return Crossing{t + times.origin_s, x + vx * t + 0.5 * gx * (t * t), vx + gx * t, speed};
}

/// Standard deviations of a number with known gradient.
class Uncertainty {
 public:
  explicit Uncertainty(const ShotFit& fit) : fit_(fit) {
    for (std::size_t i = 0; i < kNoiseCount; ++i) {
      const Noise noise = static_cast<Noise>(i);
      if (noise == Noise::stated || noise == Noise::equator || !fit.levels[i].used) continue;
      information_[i] = information(fit.observations, fit.joint, noise);
      any_level_ = true;
    }
    any_level_ = any_level_ || fit.levels[static_cast<std::size_t>(Noise::equator)].used;
    // The diameter enters the fit through the diameters' images only: they say scale * diameter.
    double pull = 0.0;
    for (const Observation& o : fit.observations.images) {
      if (!o.use_diameter) continue;
      const double sd = fit.observations.diameter_sd(o);
      pull -= fit.observations.ball_diameter_m * fit.joint.unknowns[kScale] / (sd * sd);
    }
    by_diameter_ = fit.joint.covariance.col(kScale) * pull;
  }

  /// Absent where a level that the number depends on has no residuals to be known from.
  std::optional<double> statistical(const Number& q) const {
    const JointVector g = joint_gradient(q);
    const JointVector u = fit_.joint.covariance * g;
    double variance = g.dot(u) + spin_variance(q, &SpinFit::variance);
    if (!std::isfinite(variance) || variance < 0.0) return std::nullopt;  // a frame of absurd numbers
    if (!any_level_) return std::sqrt(variance);
    double uncertain = 0.0;  // sum of (estimated share)^2 / its degrees of freedom
    double fewest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < kNoiseCount; ++i) {
      const EstimatedLevel& level = fit_.levels[i];
      if (!level.used) continue;
      const double part = static_cast<Noise>(i) == Noise::equator
                              ? spin_variance(q, &SpinFit::estimated_variance)
                              : u.dot(information_[i] * u);
      const double share = std::min(part / variance, 1.0);
      if (!(share > 1e-9)) continue;
      if (level.degrees_of_freedom == 0.0) return std::nullopt;
      uncertain += share * share / level.degrees_of_freedom;
      fewest = std::min(fewest, level.degrees_of_freedom);
    }
    const double sd = std::sqrt(variance);
    if (!(uncertain > 0.0)) return sd;
    return sd * student_t_sigma(std::max(1.0 / uncertain, fewest));  // Welch-Satterthwaite
  }

  std::optional<double> systematic(const Number& q) const {
    if (!fit_.observations.ball_diameter_sd_m) return std::nullopt;
    const double slope = q.grad[kDiameter] + joint_gradient(q).dot(by_diameter_);
    return std::abs(slope) * *fit_.observations.ball_diameter_sd_m;
  }

 private:
  static JointVector joint_gradient(const Number& q) { return Eigen::Map<const JointVector>(q.grad.data()); }

  double spin_variance(const Number& q, double SpinFit::*which) const {
    double sum = 0.0;
    for (std::size_t leg = 0; leg < 2; ++leg) {
      const double g = q.grad[kSpin[leg]];
      if (fit_.spin[leg]) sum += g * g * (*fit_.spin[leg]).*which;
    }
    return sum;
  }

  const ShotFit& fit_;
  std::array<JointMatrix, kNoiseCount> information_;  // of the levels in use
  JointVector by_diameter_;
  bool any_level_ = false;
};

class Propagation {
 public:
  Propagation(const ShotFit& fit, Readout& readout) : fit_(fit), readout_(readout), uncertainty_(fit) {}

  void legs() {
    for (std::size_t leg = 0; leg < 2; ++leg) {
      crossing_[leg] = crossing(fit_, leg);
      if (!fit_.joint.legs[leg].fitted || !fit_.spin[leg]) readout_.flags.set(Flag::too_few_images);
      if (fit_.joint.legs[leg].fitted && !crossing_[leg]) readout_.flags.set(Flag::degenerate_geometry);
      if (fit_.spin[leg]) omega_[leg] = Number::variable(fit_.spin[leg]->omega_radps, kSpin[leg]);
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
    const Crossing& td = *crossing_[0];
    const Crossing& lo = *crossing_[1];
    const Number e = -lo.vy_mps / td.vy_mps;
    const Number lost = td.vx_mps - lo.vx_mps;
    const Number mu = lost / (lo.vy_mps - td.vy_mps);
    put(Quantity::e, e);
    put(Quantity::mu, mu);
    const Number dwell = lo.time_s - td.time_s;
    if (dwell.value > 0.0) {
      put(Quantity::dwell_time_ms, dwell * 1e3);
      put(Quantity::dwell_distance_cm, (lo.x_m - td.x_m) * 1e2);
    } else {
      readout_.flags.set(Flag::degenerate_geometry);
    }
    if (temperature_c) put(Quantity::court_pace, court_pace_rating(e, mu, *temperature_c));
    if (omega_[0]) regime(lost, td.vx_mps + radius(fit_) * *omega_[0]);
    readout_.court_pace_conforming =
        temperature_c && omega_[0] &&
        court_pace_limits_kept(*readout_.value[Quantity::v_td_mps], *readout_.value[Quantity::theta_in_deg],
                               omega_[0]->value);
  }

 private:
  struct LegQuantities {
    Quantity theta, vx, vy, v, omega;
  };

  void leg(std::size_t leg, const LegQuantities& names) {
    if (const auto& at = crossing_[leg]) {
      put(names.theta, atan2(at->vy_mps, at->vx_mps) * degrees(1.0));
      put(names.vx, at->vx_mps);
      put(names.vy, at->vy_mps);
      put(names.v, hypot(at->vx_mps, at->vy_mps));
    }
    if (omega_[leg]) put(names.omega, *omega_[leg]);
  }

  void put(Quantity quantity, const Number& number) {
    if (!std::isfinite(number.value)) return;
    readout_.value[quantity] = number.value;
    readout_.sd[quantity] = uncertainty_.statistical(number);
    readout_.sd_systematic[quantity] = uncertainty_.systematic(number);
  }

  /// What is missing of the change of vx that ends the slip: |slip| alpha / (1 + alpha), against its own sd.
  void regime(const Number& lost, const Number& slip) {
    const auto size = [](const Number& n) { return n.value < 0.0 ? -n : n; };
    const Number missing = size(slip) * (kInertiaFactor / (1.0 + kInertiaFactor)) - size(lost);
    const std::optional<double> sd = uncertainty_.statistical(missing);
    if (missing.value <= 0.0) {
      readout_.regime = Regime::grips;
    } else {
      readout_.regime = sd && missing.value > 2.0 * *sd ? Regime::slides : Regime::unclear;
    }
  }

  const ShotFit& fit_;
  Readout& readout_;
  Uncertainty uncertainty_;
  std::array<std::optional<Crossing>, 2> crossing_;
  std::array<std::optional<Number>, 2> omega_;
};

}  // namespace

void propagate(const ShotFit& fit, std::optional<double> temperature_c, Readout& readout) {
  Propagation propagation(fit, readout);
  propagation.legs();
  propagation.impact(temperature_c);
}

}  // namespace strobe::reduction
