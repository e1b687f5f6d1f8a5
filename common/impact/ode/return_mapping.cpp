#include "common/impact/ode/return_mapping.hpp"

#include <algorithm>

#include "common/impact/ode/contact_system.hpp"
#include "common/impact/ode/normal_motion.hpp"
#include "common/impact/ode/oscillation.hpp"

namespace strobe::impact {

namespace {

using detail::System;

/// Depth and its rate half a step later, about the depth at rest.
struct NormalStep {
  double depth_depth, depth_rate, rate_depth, rate_rate;

  NormalStep(double zeta, double time) {
    const detail::Oscillation o = detail::oscillation((1.0 - zeta) * (1.0 + zeta), time);
    const double fade = std::exp(-zeta * time);
    const double cosine = fade * o.cosine, sine = fade * o.sine;
    depth_depth = cosine + zeta * sine;
    depth_rate = sine;
    rate_depth = -sine;
    rate_rate = cosine - zeta * sine;
  }
};

/// Stretch and slip of a grip a step later, from those before it and from a constant force.
struct GripStep {
  double stretch_stretch, stretch_slip, stretch_force, slip_stretch, slip_slip, slip_force;

  GripStep(const System& s, double beta, double time) {
    const double b = 0.5 * beta * s.ct, stiffness = beta * s.kt, omega2 = stiffness - b * b;
    double cosine, sine;
    if (omega2 > 0.0) {
      const detail::Oscillation o = detail::oscillation(omega2, time);
      const double fade = std::exp(-b * time);
      cosine = fade * o.cosine;
      sine = fade * o.sine;
    } else {
      // Of both exponents the small one would be a difference of large numbers.
      const double q = std::sqrt(-omega2);
      const double slow = std::exp(-stiffness / (b + q) * time), fast = std::exp(-(b + q) * time);
      cosine = 0.5 * (slow + fast);
      sine = q * time > 1e-6 ? 0.5 * (slow - fast) / q : time * slow;
    }
    stretch_stretch = cosine + b * sine;
    stretch_slip = sine;
    stretch_force = (1.0 - stretch_stretch) / stiffness;
    slip_stretch = -stiffness * sine;
    slip_slip = cosine - b * sine;
    slip_force = sine;
  }
};

/// Stretch of a slipping spring a step later, from that before it and from the forces at both ends.
struct SlipStep {
  double stretch = 0.0, force_before = 0.0, force_after;

  SlipStep(const System& s, double time) {
    double mean = 0.0;
    if (s.ct > 0.0) {
      const double decay = s.kt / s.ct * time;
      stretch = std::exp(-decay);
      mean = decay > 1e-6 ? (1.0 - stretch) / decay : 1.0 - 0.5 * decay;
    }
    force_before = (mean - stretch) * s.mu / s.kt;
    force_after = (1.0 - mean) * s.mu / s.kt;
  }
};

class ReturnMapping {
 public:
  ReturnMapping(const System& system, double release_tau, int steps)
      : s_(system),
        steps_(steps),
        size_(release_tau / steps),
        beta_(1.0 + 1.0 / s_.alpha),
        half_(s_.zeta, 0.5 * size_),
        grip_(s_, beta_, size_),
        slip_step_(s_, size_) {}

  void run() {
    const double zeta2 = 2.0 * s_.zeta, g = s_.gravity, per_radius = 1.0 / s_.radius;
    double depth = -g, force = zeta2;  // the depth about that at rest
    for (int i = 0; i < steps_; ++i) {
      const double middle = half_.depth_depth * depth + half_.depth_rate * rate_;
      const double middle_rate = half_.rate_depth * depth + half_.rate_rate * rate_;
      const double before = rate_, force_before = force;
      depth = half_.depth_depth * middle + half_.depth_rate * middle_rate;
      rate_ = half_.rate_depth * middle + half_.rate_rate * middle_rate;
      force = (depth + g) + zeta2 * rate_;
      const double impulse = std::max(0.0, (before - rate_) + g * size_);
      const double share = std::min(std::max((middle + g) * per_radius, 0.0), 1.0);
      advance(impulse, s_.delta * std::sqrt(share * (2.0 - share)) * impulse, force_before, force);
    }
  }

  Rebound rebound() const {
    Rebound out;
    const double spin = (couple_ - friction_) / s_.alpha, time = size_ * steps_;
    const double vx_change = s_.along * time - friction_;
    out.lift_off = {s_.speed_mps * (s_.vx0 + vx_change), -s_.speed_mps * rate_,
                    s_.speed_mps * (s_.w0 + spin) / s_.radius_m};
    out.regime = held_ ? Regime::grips : Regime::slides;
    out.slip_lo_mps = s_.speed_mps * slip_;
    out.impulse_ratio = (0.0 - vx_change) / (1.0 - rate_);
    out.offset_m = s_.radius_m * couple_ / (1.0 - rate_);
    return out;
  }

 private:
  void advance(double impulse, double couple_limit, double force_before, double force_after) {
    const double couple = couple_limit * s_.offset_direction(spin_ + 0.5 * spin_change_);
    const double turned = couple / s_.alpha + s_.along * size_;
    const double push = turned / size_;
    const double held_slip =
        grip_.slip_stretch * stretch_ + grip_.slip_slip * slip_ + grip_.slip_force * push;
    double friction = ((slip_ + turned) - held_slip) / beta_;
    const double limit = s_.mu * impulse;
    if (std::abs(friction) <= limit) {
      stretch_ = grip_.stretch_stretch * stretch_ + grip_.stretch_slip * slip_ + grip_.stretch_force * push;
      slip_ = held_slip;
      held_ = held_ || slipped_;
    } else {
      const double sign = std::copysign(1.0, friction);
      friction = sign * limit;
      slip_ += turned - beta_ * friction;
      stretch_ = slip_step_.stretch * stretch_ +
                 sign * (slip_step_.force_before * force_before + slip_step_.force_after * force_after);
      slipped_ = true;
    }
    friction_ += friction;
    couple_ += couple;
    spin_change_ = (couple - friction) / s_.alpha;
    spin_ += spin_change_;
    if (slip_ * s_.slip0 <= 0.0) held_ = true;
  }

  const System& s_;
  int steps_;
  double size_, beta_;
  NormalStep half_;
  GripStep grip_;
  SlipStep slip_step_;
  double rate_ = 1.0;
  double stretch_ = 0.0, slip_ = s_.slip0, spin_ = s_.w0, spin_change_ = 0.0;
  double friction_ = 0.0, couple_ = 0.0;
  bool held_ = false, slipped_ = false;
};

}  // namespace

tl::expected<Rebound, InputError> return_mapping(const ball::Ball& ball, const Motion& touchdown,
                                                 const ContactCoefficients& coefficients, int steps) {
  if (steps < kMinReturnMappingSteps || steps > kMaxReturnMappingSteps)
    return tl::unexpected(InputError::tolerance_out_of_range);
  const auto system = detail::make_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  double release = system->frequency_radps * coefficients.dwell_s;
  if (system->gravity != 0.0) {
    const auto normal = detail::NormalMotion::make(*system);
    if (!normal)
      return simulate(ball, touchdown, coefficients).map([](const ContactSummary& s) {
        return Rebound{s.lift_off, s.regime, s.slip_lo_mps, s.impulse_ratio, s.mean_offset_m};
      });
    release = normal->release_tau();
  }
  ReturnMapping mapping(*system, release, steps);
  mapping.run();
  return mapping.rebound();
}

}  // namespace strobe::impact
