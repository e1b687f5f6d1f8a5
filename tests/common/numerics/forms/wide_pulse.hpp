// The damped sine pulse in 50 digits: the force as the solution of y'' = -2f·y' - (1 + f²)·y, y(0) = 0,
// y'(0) = 1, integrated once and twice as a Taylor series of as many terms as it takes (exact form), or the
// thesis's formulas as printed (simplified form).
#pragma once

#include "common/impact/closed_form/sine_pulse.hpp"
#include "tests/common/numerics/forms/wide.hpp"

namespace strobe::numerics {

struct WideIntegrals {
  Wide first;   ///< of exp(-f·phi)·sin(phi) over 0…theta
  Wide second;  ///< integral of the first
};

inline WideIntegrals taylor_integrals(const Wide& f, const Wide& theta) {
  const Wide damping = 2 * f * theta, stiffness = (1 + f * f) * theta * theta;
  Wide before = 0, term = theta;  // a_n·theta^n for n = 0, 1
  Wide first = term / 2, second = term / 6;
  int beneath = 0;
  for (int n = 0; n < 400 && beneath < 2; ++n) {
    const Wide next = (-damping * (n + 1) * term - stiffness * before) / ((n + 1) * (n + 2));
    before = term;
    term = next;
    first += term / (n + 3);
    second += term / ((n + 3) * (n + 4));
    beneath = abs(term) < theta * Wide(1e-60) ? beneath + 1 : 0;
  }
  return {first * theta, second * theta * theta};
}

class WidePulse {
 public:
  WidePulse(impact::PulseForm form, const Wide& f) : exact_(form == impact::PulseForm::exact), f_(f) {}

  /// The damping of a restitution: the total impulse is 1 + e. `near` is any double close to it.
  static WidePulse of_restitution(impact::PulseForm form, double e, double near) {
    if (form == impact::PulseForm::simplified) return {form, -log(Wide(e)) / wide_pi()};
    if (e == 1.0) return {form, 0};
    const auto miss = [e](const Wide& f) { return Wide(taylor_integrals(f, wide_pi()).first - 1 - Wide(e)); };
    Wide older = near * (1 - Wide(1e-9)), old = near * (1 + Wide(1e-9));
    Wide miss_older = miss(older), miss_old = miss(old);
    for (int i = 0; i < 12 && miss_old != miss_older; ++i) {
      const Wide next = old - miss_old * (old - older) / (miss_old - miss_older);
      older = old;
      miss_older = miss_old;
      old = next;
      if (abs(old - older) < abs(old) * Wide(1e-42)) break;
      miss_old = miss(old);
    }
    return {form, old};
  }

  const Wide& damping() const { return f_; }
  Wide impulse(const Wide& theta) const {
    return exact_ ? taylor_integrals(f_, theta).first : Wide(1 - exp(-f_ * theta) * cos(theta));
  }
  Wide path(const Wide& theta) const {
    return exact_ ? taylor_integrals(f_, theta).second : Wide(theta - exp(-f_ * theta) * sin(theta));
  }
  /// Derivative of impulse().
  Wide slope(const Wide& theta) const {
    return exp(-f_ * theta) * (sin(theta) + (exact_ ? Wide(0) : Wide(f_ * cos(theta))));
  }
  /// Angle at which the impulse is largest.
  Wide end_of_rise() const { return exact_ ? wide_pi() : Wide(wide_pi() - atan(f_)); }

  /// First angle at which the impulse is `target`; Newton within a bracket, from the double's answer.
  Wide angle_reaching(const Wide& target, double near) const {
    if (target <= 0) return 0;
    Wide low = 0, high = end_of_rise(), angle = near;
    if (impulse(high) <= target) return high;
    for (int i = 0; i < 300; ++i) {
      if (angle <= low || angle >= high) angle = (low + high) / 2;
      const Wide miss = impulse(angle) - target;
      (miss < 0 ? low : high) = angle;
      const Wide step = miss / slope(angle);
      angle -= step;
      if (abs(step) < angle * Wide(1e-38) || high - low < high * Wide(1e-38)) break;
    }
    return angle;
  }

 private:
  bool exact_;
  Wide f_;
};

}  // namespace strobe::numerics
