#include "common/contact/peaks.hpp"

#include <array>
#include <cmath>
#include <string>

namespace strobe::contact {

namespace {

using impact::InputError;

enum Index {
  kForce,
  kForceFraction,
  kForceTime,
  kDepth,
  kDepthFraction,
  kDepthTime,
  kFriction,
  kFrictionFraction,
  kFrictionTime,
  kRotation,
  kGripFraction,
  kGripTime,
  kCount,
};

struct Values {
  std::array<double, kCount> of{};
  bool grips = false;
};

/// The largest friction before the grip: at the force's peak, or at the grip where that comes first; without
/// slip, the largest that rolling asks for.
double friction_fraction(const SpinPulse& pulse, double peak_fraction) {
  const auto grip = pulse.grip_fraction();
  if (!grip || *grip >= peak_fraction || *grip == 0.0) return peak_fraction;
  return *grip;
}

double friction_before(const SpinPulse& pulse, double fraction) {
  const SpinPulseState s = pulse.at_fraction(fraction);
  if (pulse.grip_fraction() == 0.0) return std::abs(s.fx_n);
  return pulse.input().mu * s.fy_n;
}

Values evaluate(const SpinPulse& pulse) {
  const double dwell = pulse.input().dwell_s;
  Values v;
  const auto put = [&v, dwell](Index size, double value, double fraction) {
    v.of[size] = value;
    v.of[size + 1] = fraction;
    v.of[size + 2] = fraction * dwell;
  };
  const double peak = pulse.largest_force_fraction();
  const double deepest = pulse.deepest_fraction();
  const double rub = friction_fraction(pulse, peak);
  put(kForce, pulse.at_fraction(peak).fy_n, peak);
  put(kDepth, -pulse.at_fraction(deepest).y_m, deepest);
  put(kFriction, friction_before(pulse, rub), rub);
  v.of[kRotation] = pulse.total_rotation_rad();
  v.grips = pulse.regime() == Regime::grips;
  v.of[kGripFraction] = pulse.grip_fraction().value_or(1.0);
  v.of[kGripTime] = v.of[kGripFraction] * dwell;
  return v;
}

using Variances = std::array<double, kCount>;

/// Adds what one input contributes: the square of (difference quotient · sd).
template <typename Set>
void add_variance(Variances& variances, const SpinPulseInput& input, const Values& centre, double sd,
                  Set set) {
  if (!(sd > 0.0)) return;
  const double step = 0.01 * sd;
  const auto moved = [&](double by) {
    SpinPulseInput in = input;
    set(in, by);
    return SpinPulse::make(in);
  };
  const auto above = moved(step);
  const auto below = moved(-step);
  if (!above && !below) return;
  const Values high = above ? evaluate(*above) : centre;
  const Values low = below ? evaluate(*below) : centre;
  const double width = (above ? step : 0.0) + (below ? step : 0.0);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double change = (high.of[i] - low.of[i]) / width * sd;
    variances[i] += change * change;
  }
}

bool valid(const SpinPulseSd& s) {
  for (const double sd : {s.vx_mps, s.vy_mps, s.omega_radps, s.e, s.mu, s.dwell_s, s.diameter_m, s.mass_kg,
                          s.alpha, s.offset_m})
    if (!std::isfinite(sd) || sd < 0.0) return false;
  return true;
}

Variances propagated(const SpinPulseInput& in, const Values& centre, const SpinPulseSd& s) {
  Variances out{};
  const auto add = [&](double sd, auto set) { add_variance(out, in, centre, sd, set); };
  add(s.vx_mps, [](SpinPulseInput& i, double by) { i.touchdown.vx_mps += by; });
  add(s.vy_mps, [](SpinPulseInput& i, double by) { i.touchdown.vy_mps += by; });
  add(s.omega_radps, [](SpinPulseInput& i, double by) { i.touchdown.omega_radps += by; });
  add(s.e, [](SpinPulseInput& i, double by) { i.e += by; });
  add(s.mu, [](SpinPulseInput& i, double by) { i.mu += by; });
  add(s.dwell_s, [](SpinPulseInput& i, double by) { i.dwell_s += by; });
  add(s.diameter_m, [](SpinPulseInput& i, double by) { i.ball.diameter_m += by; });
  add(s.mass_kg, [](SpinPulseInput& i, double by) { i.ball.mass_kg += by; });
  add(s.alpha, [](SpinPulseInput& i, double by) { i.ball.alpha += by; });
  add(s.offset_m, [](SpinPulseInput& i, double by) { i.offset_m += by; });
  return out;
}

struct Drop {
  double ratio;
  double sum_squares;
};

Drop fitted_drop(const data::ContactSet& set, const SpinPulse& pulse) {
  double yy = 0.0, ym = 0.0;
  for (const data::ContactRow& row : set.rows) {
    if (is_end_point(row)) continue;
    const double y = pulse.at_fraction(row.time_fraction).y_m;
    yy += y * y;
    ym += y * row.y_fraction * pulse.input().ball.diameter_m;
  }
  return {ym / yy, yy};
}

}  // namespace

tl::expected<Peaks, InputError> peaks(const SpinPulseInput& input, const SpinPulseSd& sd) {
  if (!valid(sd)) return tl::unexpected(InputError::not_finite);
  const auto pulse = SpinPulse::make(input);
  if (!pulse) return tl::unexpected(pulse.error());
  const Values centre = evaluate(*pulse);
  const Variances variances = propagated(input, centre, sd);
  const auto value = [&](Index i) { return ValueSd{centre.of[i], std::sqrt(variances[i])}; };
  Peaks out{.normal_force = {value(kForce), value(kForceTime), value(kForceFraction)},
            .deformation = {value(kDepth), value(kDepthTime), value(kDepthFraction)},
            .friction_force = {value(kFriction), value(kFrictionTime), value(kFrictionFraction)},
            .total_rotation_rad = value(kRotation),
            .grip_fraction = std::nullopt,
            .grip_time_s = std::nullopt};
  if (centre.grips) {
    out.grip_fraction = value(kGripFraction);
    out.grip_time_s = value(kGripTime);
  }
  return out;
}

Result<DropRatio> drop_ratio(const data::ContactSet& set, const SpinPulseInput& input,
                             const SpinPulseSd& sd) {
  const auto pulse = SpinPulse::make(input);
  if (!pulse) return fail(std::string(impact::message(pulse.error())));
  const auto best = peaks(input, sd);
  if (!best) return fail(std::string(impact::message(best.error())));
  DropRatio out;
  for (const data::ContactRow& row : set.rows) out.n += is_end_point(row) ? 0 : 1;
  const Drop drop = fitted_drop(set, *pulse);
  if (out.n < 2 || !(drop.sum_squares > 0.0))
    return fail("at least two rows are needed between touchdown and lift-off");
  out.ratio = drop.ratio;
  double squares = 0.0;
  for (const data::ContactRow& row : set.rows) {
    if (is_end_point(row)) continue;
    const double scaled = out.ratio * pulse->at_fraction(row.time_fraction).y_m;
    squares += std::pow(row.y_fraction * input.ball.diameter_m - scaled, 2);
  }
  out.see_m = std::sqrt(squares / (out.n - 1));
  if (out.see_m > data::kRounding * std::abs(out.ratio) * std::sqrt(drop.sum_squares))
    out.sd_images = out.see_m / std::sqrt(drop.sum_squares);
  const ValueSd depth = best->deformation.size;
  const double diameter_share = sd.diameter_m / input.ball.diameter_m;
  out.sd_inputs = std::abs(out.ratio) * std::hypot(depth.sd / depth.value, diameter_share);
  out.depth_m = out.ratio * depth.value;
  return out;
}

}  // namespace strobe::contact
