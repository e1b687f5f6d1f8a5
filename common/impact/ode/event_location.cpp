#include "common/impact/ode/event_location.hpp"

#include <algorithm>
#include <limits>

namespace strobe::impact::detail {

namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

/// The point b >= a where f (positive at a, not at b) has just become <= 0, by regula falsi with the
/// Illinois weights, and bisection wherever that does not halve the bracket in three steps.
template <typename Function>
double refine(Function&& f, double a, double fa, double b, double fb) {
  double previous_width = b - a;
  int side = 0;
  for (int i = 1; i <= 120 && b - a > 2.0 * kEps * b && fb != 0.0; ++i) {
    double c = (a * fb - b * fa) / (fb - fa);
    if (i % 4 == 0) {
      if (b - a > 0.5 * previous_width) c = 0.5 * (a + b);
      previous_width = b - a;
    }
    // Never an end itself: the last bracket closes on the root from both sides.
    const double margin = std::max(kEps * b, 1e-3 * kEps * (b - a));
    c = std::clamp(c, a + margin, b - margin);
    if (!(c > a && c < b)) break;
    const double fc = f(c);
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

/// Where the parabola through three neighbouring samples at x-h, x, x+h is least, if that is quarters them.
std::optional<double> lowest(double x, double h, double left, double middle, double right) {
  const double bend = left - 2.0 * middle + right;
  if (!(bend > 0.0)) return std::nullopt;
  const double shift = 0.5 * (left - right) / bend;
  if (std::abs(shift) > 1.0) return std::nullopt;
  if (middle - 0.25 * (left - right) * shift * 0.5 > 0.25 * std::max(left, right)) return std::nullopt;
  return x + h * shift;
}

constexpr int kSamples = 4;

/// First interval of the step, in fractions of it, at whose end the function of the interpolant is negative.
std::optional<Bracket> bracket_crossing(const DenseStep& dense, EventFunction function, double start) {
  std::array<double, kSamples + 1> value{start};
  for (int i = 1; i <= kSamples; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const State& z = i == kSamples ? dense.end : dense.quarters[at - 1];
    const EventValue v = event_value(dense.system, function, dense.step.mode, z);
    value[at] = v.value;
    if (v.value < -v.noise) return Bracket{(i - 1.0) / kSamples, static_cast<double>(i) / kSamples};
    if (i < 2) continue;
    // A minimum between samples.
    const double h = 1.0 / kSamples;
    const auto dip = lowest((i - 1) * h, h, value[at - 2], value[at - 1], value[at]);
    if (!dip || *dip <= 0.0 || *dip >= 1.0) continue;
    const EventValue least = event_value(dense.system, function, dense.step.mode, dense.interpolate(*dip));
    if (least.value < -least.noise) return Bracket{(i - 2) * h, *dip};
  }
  return std::nullopt;
}

}  // namespace

EventValue event_value(const System& s, EventFunction function, ContactMode mode, const State& z) {
  const double normal = s.normal_force(z);
  const double slip = s.slip(z);
  const double slip_noise = std::abs(s.slip0) + std::abs(z[kVxChange]) + std::abs(z[kSpinChange]);
  const double hold_noise = s.kt * std::abs(z[kStretch]) + s.ct * slip_noise + s.mu * std::abs(normal);
  const double scale = 32.0 * kEps;
  switch (function) {
    case EventFunction::release:
      return {normal, scale * (std::abs(z[kDepth]) + 2.0 * s.zeta * std::abs(z[kDepthRate]))};
    case EventFunction::hold_forward:
      return {s.mu * normal - s.holding_force(z), scale * hold_noise};
    case EventFunction::hold_backward:
      return {s.mu * normal + s.holding_force(z), scale * hold_noise};
    case EventFunction::sliding: {
      const double sigma = direction(mode);
      if (s.ct > 0.0) return {sigma * s.holding_force(z) - s.mu * normal, scale * hold_noise};
      const double limit_rate = s.mu * s.normal_force_rate(z) / s.kt;
      return {sigma * slip - limit_rate, scale * (slip_noise + std::abs(limit_rate))};
    }
    case EventFunction::footprint_full:
      return {s.radius - z[kDepth], scale * s.radius};
    case EventFunction::footprint_shrinks:
      return {z[kDepth] - s.radius, scale * s.radius};
    case EventFunction::friction:
      return {s.friction(z, mode), scale * hold_noise};
    case EventFunction::depth_rate:
      return {z[kDepthRate], 0.0};
    case EventFunction::force_rate:
      return {s.normal_force_rate(z), 0.0};
    case EventFunction::friction_rate: {
      if (mode != ContactMode::grips) return {direction(mode) * s.mu * s.normal_force_rate(z), 0.0};
      const State d = derivative(s, z, mode);
      return {s.kt * slip + s.ct * (d[kVxChange] + d[kSpinChange]), 0.0};
    }
    case EventFunction::slip:
      return {slip, 0.0};
  }
  return {normal, 0.0};
}

State DenseStep::at(double size) const {
  if (size == 0.0) return step.start;
  *evaluations += 5;
  return take_step(system, step.mode, step.start, step.derivative, size);
}

void DenseStep::interpolate_quarters() {
  for (std::size_t i = 0; i < quarters.size(); ++i)
    quarters[i] = interpolate(static_cast<double>(i + 1) / kSamples);
}

State DenseStep::interpolate(double fraction) const {
  const double back = 1.0 - fraction;
  State z{};
  for (std::size_t i = 0; i <= kStretch; ++i) {
    const double rise = end[i] - step.start[i];
    z[i] = step.start[i] + fraction * (rise + back * (back * (step.size * step.derivative[i] - rise) -
                                                      fraction * (step.size * end_derivative[i] - rise)));
  }
  return z;
}

std::optional<double> find_crossing(const DenseStep& dense, EventFunction function) {
  const EventValue start = event_value(dense.system, function, dense.step.mode, dense.step.start);
  if (start.value < -start.noise) return 0.0;
  const auto bracket = bracket_crossing(dense, function, std::max(start.value, 0.0));
  if (!bracket) return std::nullopt;
  const auto value_at = [&](double size) {
    return event_value(dense.system, function, dense.step.mode, dense.at(size)).value;
  };
  double low = bracket->low * dense.step.size;
  double f_low = bracket->low == 0.0 ? std::max(start.value, start.noise) : value_at(low);
  if (!(f_low > 0.0)) {
    // The interpolant missed the zero by less than its own error.
    low = 0.0;
    f_low = std::max(start.value, start.noise);
  }
  const double high = bracket->high * dense.step.size;
  const double f_high = value_at(high);
  if (f_high > 0.0) {
    // Of a long step the interpolant may cross early; its end is no interpolant's.
    const EventValue end = event_value(dense.system, function, dense.step.mode, dense.end);
    if (!(end.value < -end.noise)) return std::nullopt;
    return refine(value_at, high, f_high, dense.step.size, end.value);
  }
  if (!(f_low > 0.0)) return 0.0;  // it is zero at the start and known without rounding
  return refine(value_at, low, f_low, high, f_high);
}

std::optional<double> find_sign_change(const DenseStep& dense, EventFunction function, double size,
                                       const State& end, int sign) {
  const double first = event_value(dense.system, function, dense.step.mode, dense.step.start).value;
  const double last = event_value(dense.system, function, dense.step.mode, end).value;
  const bool falls = first > 0.0 && last <= 0.0 && sign <= 0;
  const bool rises = first < 0.0 && last >= 0.0 && sign >= 0;
  if (!falls && !rises) return std::nullopt;
  const double up = falls ? 1.0 : -1.0;
  const auto value_at = [&](double part) {
    return up * event_value(dense.system, function, dense.step.mode, dense.at(part)).value;
  };
  return refine(value_at, 0.0, up * first, size, up * last);
}

}  // namespace strobe::impact::detail
