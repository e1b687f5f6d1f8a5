#include "common/impact/ode/event_location.hpp"

#include <algorithm>
#include <limits>

namespace strobe::impact::detail {

namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

/// The point b >= a where `function` (positive at a, not at b) has just become <= 0, by regula falsi with the
/// Illinois weights, and bisection wherever that does not halve the bracket in three steps.
template <typename Function>
double refine(Function&& function, double a, double fa, double b, double fb) {
  double guard = b - a;
  int side = 0;
  for (int i = 1; i <= 120 && b - a > 2.0 * kEps * b && fb != 0.0; ++i) {
    double c = (a * fb - b * fa) / (fb - fa);
    if (i % 4 == 0) {
      if (b - a > 0.5 * guard) c = 0.5 * (a + b);
      guard = b - a;
    }
    // Never an end itself: the last bracket closes on the root from both sides.
    const double margin = std::max(kEps * b, 1e-3 * kEps * (b - a));
    c = std::clamp(c, a + margin, b - margin);
    if (!(c > a && c < b)) break;
    const double fc = function(c);
    if (fc > 0.0) {
      a = c;
      fa = fc;
      if (side == 1) fb *= 0.5;
      side = 1;
    } else {
      b = c;
      fb = fc;
      if (side == -1) fa *= 0.5;
      side = -1;
    }
  }
  return b;
}

struct Bracket {
  double low;
  double high;
};

/// Where the parabola through three neighbouring samples at x-h, x, x+h is least, if that is between them.
std::optional<double> lowest(double x, double h, double left, double middle, double right) {
  const double bend = left - 2.0 * middle + right;
  if (!(bend > 0.0)) return std::nullopt;
  const double shift = 0.5 * (left - right) / bend;
  if (std::abs(shift) > 1.0) return std::nullopt;
  if (middle - 0.25 * (left - right) * shift * 0.5 > 0.25 * std::max(left, right)) return std::nullopt;
  return x + h * shift;
}

constexpr int kSamples = 4;

/// First stretch of the step, in fractions, at whose end the cubic's function is negative.
std::optional<Bracket> glance_for_crossing(const TakenStep& taken, Watched what, double start) {
  std::array<double, kSamples + 1> value{start};
  for (int i = 1; i <= kSamples; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const State& z = i == kSamples ? taken.end : taken.between[at - 1];
    const Value v = watch(taken.system, what, taken.step.mode, z);
    value[at] = v.value;
    if (v.value < -v.noise) return Bracket{(i - 1.0) / kSamples, static_cast<double>(i) / kSamples};
    if (i < 2) continue;
    // A dip between samples.
    const double h = 1.0 / kSamples;
    const auto dip = lowest((i - 1) * h, h, value[at - 2], value[at - 1], value[at]);
    if (!dip || *dip <= 0.0 || *dip >= 1.0) continue;
    const Value least = watch(taken.system, what, taken.step.mode, taken.glance(*dip));
    if (least.value < -least.noise) return Bracket{(i - 2) * h, *dip};
  }
  return std::nullopt;
}

}  // namespace

Value watch(const System& s, Watched what, ContactMode mode, const State& z) {
  const double normal = s.normal_force(z);
  const double slip = s.slip(z);
  const double slip_noise = std::abs(s.slip0) + std::abs(z[kVxChange]) + std::abs(z[kSpinChange]);
  const double hold_noise = s.kt * std::abs(z[kStretch]) + s.ct * slip_noise + s.mu * std::abs(normal);
  const double scale = 32.0 * kEps;
  switch (what) {
    case Watched::release:
      return {normal, scale * (std::abs(z[kDepth]) + 2.0 * s.zeta * std::abs(z[kDepthRate]))};
    case Watched::hold_forward:
      return {s.mu * normal - s.holding_force(z), scale * hold_noise};
    case Watched::hold_backward:
      return {s.mu * normal + s.holding_force(z), scale * hold_noise};
    case Watched::sliding: {
      const double sigma = direction(mode);
      if (s.ct > 0.0) return {sigma * s.holding_force(z) - s.mu * normal, scale * hold_noise};
      const double limit_rate = s.mu * s.normal_force_rate(z) / s.kt;
      return {sigma * slip - limit_rate, scale * (slip_noise + std::abs(limit_rate))};
    }
    case Watched::footprint_full:
      return {s.radius - z[kDepth], scale * s.radius};
    case Watched::footprint_shrinks:
      return {z[kDepth] - s.radius, scale * s.radius};
    case Watched::friction:
      return {s.friction(z, mode), scale * hold_noise};
    case Watched::depth_rate:
      return {z[kDepthRate], 0.0};
    case Watched::force_rate:
      return {s.normal_force_rate(z), 0.0};
    case Watched::friction_rate: {
      if (mode != ContactMode::grips) return {direction(mode) * s.mu * s.normal_force_rate(z), 0.0};
      const State d = derivative(s, z, mode);
      return {s.kt * slip + s.ct * (d[kVxChange] + d[kSpinChange]), 0.0};
    }
    case Watched::slip:
      return {slip, 0.0};
  }
  return {normal, 0.0};
}

State TakenStep::at(double part_size) const {
  if (part_size == 0.0) return step.start;
  *evaluations += method == ContactMethod::dormand_prince ? 5 : method == ContactMethod::rk4 ? 3 : 1;
  return take_step(system, method, step.mode, step.start, step.slope, part_size);
}

void TakenStep::prepare() {
  for (std::size_t i = 0; i < between.size(); ++i) between[i] = glance(static_cast<double>(i + 1) / kSamples);
}

State TakenStep::glance(double fraction) const {
  const double back = 1.0 - fraction;
  State z{};
  for (std::size_t i = 0; i <= kStretch; ++i) {
    const double rise = end[i] - step.start[i];
    z[i] = step.start[i] + fraction * (rise + back * (back * (step.size * step.slope[i] - rise) -
                                                      fraction * (step.size * end_slope[i] - rise)));
  }
  return z;
}

std::optional<double> find_crossing(const TakenStep& taken, Watched what) {
  const Value start = watch(taken.system, what, taken.step.mode, taken.step.start);
  if (start.value < -start.noise) return 0.0;
  const auto bracket = glance_for_crossing(taken, what, std::max(start.value, 0.0));
  if (!bracket) return std::nullopt;
  const auto value_at = [&](double size) {
    return watch(taken.system, what, taken.step.mode, taken.at(size)).value;
  };
  double low = bracket->low * taken.step.size;
  double f_low = bracket->low == 0.0 ? std::max(start.value, start.noise) : value_at(low);
  if (!(f_low > 0.0)) {
    // The cubic missed it by less than its own error.
    low = 0.0;
    f_low = std::max(start.value, start.noise);
  }
  const double high = bracket->high * taken.step.size;
  const double f_high = value_at(high);
  if (f_high > 0.0) return std::nullopt;
  if (!(f_low > 0.0)) return high;
  return refine(value_at, low, f_low, high, f_high);
}

std::optional<double> find_sign_change(const TakenStep& taken, Watched what, double size, const State& end,
                                       int sign) {
  const double first = watch(taken.system, what, taken.step.mode, taken.step.start).value;
  const double last = watch(taken.system, what, taken.step.mode, end).value;
  const bool falls = first > 0.0 && last <= 0.0 && sign <= 0;
  const bool rises = first < 0.0 && last >= 0.0 && sign >= 0;
  if (!falls && !rises) return std::nullopt;
  const double up = falls ? 1.0 : -1.0;
  const auto value_at = [&](double part) {
    return up * watch(taken.system, what, taken.step.mode, taken.at(part)).value;
  };
  return refine(value_at, 0.0, up * first, size, up * last);
}

}  // namespace strobe::impact::detail
