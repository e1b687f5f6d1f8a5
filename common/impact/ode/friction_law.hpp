// Implementation of contact_collocation.hpp: the law of friction along a solved segment, positive where it
// holds, and where it is first broken. Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <limits>
#include <optional>

#include "common/impact/ode/segment_solver.hpp"

namespace strobe::impact::detail {

/// Gripping mu·N - |F|; slipping what |F| of a grip would exceed mu·N by, without a dashpot how fast it
/// would.
class FrictionLaw {
 public:
  FrictionLaw(const CollocationConstants& constants, ContactMode mode)
      : c_(constants), s_(constants.system), mode_(mode) {}

  /// Force that holds the contact point.
  double hold(double stretch, double slip) const { return s_.kt * stretch + s_.ct * slip; }
  /// Direction in which a grip breaks: of the force, or where that is 0 of what pulls next.
  ContactMode breaks_towards(const TangentialState& at) const {
    const double held = hold(at.stretch, at.slip);
    if (held != 0.0) return slipping(held);
    return slipping(at.slip != 0.0 ? at.slip : s_.along);
  }
  /// Direction of a grip's friction.
  static double side_of(double hold) { return hold < 0.0 ? -1.0 : 1.0; }

  double value(double force, double force_rate, double hold, double slip) const {
    if (mode_ == ContactMode::grips) return s_.mu * force - std::abs(hold);
    const double sign = direction(mode_);
    if (s_.ct > 0.0) return sign * hold - s_.mu * force;
    return sign * slip - s_.mu * force_rate / s_.kt;
  }
  double value(const SegmentPoint& at) const {
    const TangentialState& t = at.tangential;
    return value(c_.normal.force(at.normal), c_.normal.force_rate(at.normal), hold(t.stretch, t.slip),
                 t.slip);
  }

  /// Its rate.
  double rate(const SegmentPoint& point) const {
    const double held = hold(point.tangential.stretch, point.tangential.slip);
    const TangentialRates rates = rates_at(c_, mode_, point);
    const double force = c_.normal.force(point.normal), force_rate = c_.normal.force_rate(point.normal);
    const double hold_rate = s_.kt * rates.stretch + s_.ct * rates.slip;
    if (mode_ == ContactMode::grips)
      return s_.mu * force_rate - (held == 0.0 ? std::abs(hold_rate) : side_of(held) * hold_rate);
    const double sign = direction(mode_);
    if (s_.ct > 0.0) return sign * hold_rate - s_.mu * force_rate;
    return sign * rates.slip - s_.mu * ((s_.gravity - force) - 2.0 * s_.zeta * force_rate) / s_.kt;
  }

  /// From the law's value to a force.
  double weight() const { return mode_ != ContactMode::grips && s_.ct == 0.0 ? s_.kt : 1.0; }

  /// What the value may be wrong by at this state.
  double noise(const TangentialState& at, double tolerance) const {
    const double slip = std::abs(s_.slip0) + std::abs(at.slip);
    const bool by_slip = mode_ != ContactMode::grips && s_.ct == 0.0;
    const double scale = by_slip ? slip + s_.mu / s_.kt : s_.mu + s_.kt * std::abs(at.stretch) + s_.ct * slip;
    return 64.0 * std::numeric_limits<double>::epsilon() * scale +
           0.05 * tolerance * std::min(s_.mu, 1.0) / weight();
  }

 private:
  const CollocationConstants& c_;
  const System& s_;
  ContactMode mode_;
};

/// The law at the start, the nodes and the end of a segment.
template <std::size_t n>
class LawAlongSegment {
 public:
  LawAlongSegment(const CollocationConstants& constants, double tolerance)
      : c_(constants), tolerance_(tolerance), enough_(std::min(1e-3, 0.1 * std::sqrt(tolerance))) {}

  /// `just_switched`: friction has changed its law at the segment's start.
  template <std::size_t terms>
  void sample(const Segment& segment, const SegmentSolver<n, terms>& solver, bool just_switched) {
    const FrictionLaw law(c_, segment.mode);
    just_switched_ = just_switched;
    grips_ = segment.mode == ContactMode::grips;
    const System& s = c_.system;
    const NormalMotion& normal = c_.normal;
    const auto& slip = solver.slip();
    const auto& stretch = solver.stretch();
    const auto& force = solver.force();
    const double start_hold = law.hold(segment.start.stretch, segment.start.slip);
    start_law_ = just_switched ? 0.0
                               : law.value(normal.force(segment.from), normal.force_rate(segment.from),
                                           start_hold, segment.start.slip);
    const double kt = s.kt, ct = s.ct, mu = s.mu, sign = direction(segment.mode);
    for (std::size_t i = 0; i < kPoints; ++i) {
      hold_[i] = kt * stretch[i] + ct * slip[i];
      limit_[i] = mu * force[i];
    }
    if (grips_) {
      for (std::size_t i = 0; i < kPoints; ++i) law_[i] = limit_[i] - std::abs(hold_[i]);
    } else if (ct > 0.0) {
      for (std::size_t i = 0; i < kPoints; ++i) law_[i] = sign * hold_[i] - limit_[i];
    } else {
      for (std::size_t i = 0; i < kPoints; ++i)
        law_[i] = law.value(force[i], solver.rate()[i] + 2.0 * s.zeta * (s.gravity - force[i]), 0.0, slip[i]);
    }
    noise_ = law.noise(segment.start, tolerance_);
  }

  double at_end() const { return law_[n]; }

  /// A mode that has just begun may be broken by as much as the last was not yet when it ended, or was
  /// already. Returns false if it is broken by more before its first node.
  bool accept_start(double switch_law) {
    if (!just_switched_) return true;
    for (std::size_t i = 0; i <= n && law_[i] < 0.0; ++i) {
      if (law_[i] < -(noise_ + switch_law)) return i > 0;
      law_[i] = 0.0;
    }
    return true;
  }

  /// A law that flattens out before the sample where it is broken may have been broken and kept again between
  /// two samples, all of which fall: that takes nodes nearer to each other.
  bool may_graze() const {
    std::size_t broken = 2;
    while (broken <= n && !(law_[broken] < -noise_)) ++broken;
    if (!grips_ || broken > n) return false;
    const auto slope = [this](std::size_t i) { return (law_[i] - law_[i - 1]) / (share(i) - share(i - 1)); };
    return slope(broken) > 0.5 * slope(broken - 1) && law_[broken - 1] < 0.1 * limit_[broken - 1];
  }

  /// The share of the segment where the law is first broken, by the polynomial through its nodes. Returns
  /// nullopt if it holds throughout.
  std::optional<double> find_event() {
    double before = start_law_;
    for (std::size_t i = 0; i <= n; ++i) {
      if (law_[i] < -noise_) {
        interpolate_law(i);
        return root(i == 0 ? 0.0 : share(i - 1), share(i), std::max(before, 0.0), law_[i]);
      }
      if (i > 0 && law_[i - 1] < law_[i] && law_[i - 1] < (i > 1 ? law_[i - 2] : start_law_))
        if (const auto dip = broken_about(i - 1)) return dip;
      before = law_[i];
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t kPoints = GaussLegendre<n>::points;
  static double share(std::size_t i) { return kGaussLegendre<n>.share[i]; }

  /// Legendre coefficients of the law, gripping of that for the side to which it may break: |F| has a kink
  /// where the friction turns round.
  void interpolate_law(std::size_t near) {
    std::array<double, n> value;
    const double side = FrictionLaw::side_of(hold_[near]);
    for (std::size_t i = 0; i < n; ++i) value[i] = grips_ ? limit_[i] - side * hold_[i] : law_[i];
    for (std::size_t k = 0; k < n; ++k) {
      coefficient_[k] = 0.0;
      for (std::size_t i = 0; i < n; ++i) coefficient_[k] += kGaussLegendre<n>.coefficient[k][i] * value[i];
    }
  }

  double law_on(double share) const {
    // Clenshaw's sum.
    const double t = 2.0 * share - 1.0;
    double next = 0.0, after = 0.0;
    for (std::size_t k = n - 1; k >= 1; --k) {
      const auto degree = static_cast<double>(k);
      const double now = coefficient_[k] + (2.0 * degree + 1.0) / (degree + 1.0) * t * next -
                         (degree + 1.0) / (degree + 2.0) * after;
      after = next;
      next = now;
    }
    return coefficient_[0] + t * next - 0.5 * after;
  }

  /// The least of three samples, all of which are lawful, is the middle one.
  std::optional<double> broken_about(std::size_t middle) {
    bool interpolated = false;
    double x[3] = {middle > 0 ? share(middle - 1) : 0.0, share(middle), share(middle + 1)};
    double f[3] = {middle > 0 ? law_[middle - 1] : start_law_, law_[middle], law_[middle + 1]};
    for (int round = 0; round < 4; ++round) {
      const double left = (f[1] - f[0]) / (x[1] - x[0]), right = (f[2] - f[1]) / (x[2] - x[1]);
      const double bend = (right - left) / (x[2] - x[0]);
      if (!(bend > 0.0)) return std::nullopt;
      const double least = 0.5 * (x[0] + x[1]) - 0.5 * left / bend;
      if (!(least > x[0] && least < x[2])) return std::nullopt;
      const double fall = bend * (least - x[1]) * (least - x[1]);
      // A dip that does not come near the law is none.
      if (f[1] - 16.0 * fall > 0.5 * std::min(f[0], f[2])) return std::nullopt;
      if (!interpolated) interpolate_law(middle);
      interpolated = true;
      const double value = law_on(least);
      const bool after = least > x[1];
      if (value < -noise_) return root(after ? x[1] : x[0], least, after ? f[1] : f[0], value);
      if (std::abs(least - x[1]) < 1e-3 * (x[2] - x[0])) return std::nullopt;
      if (value < f[1]) {
        x[after ? 0 : 2] = x[1];
        f[after ? 0 : 2] = f[1];
        x[1] = least;
        f[1] = value;
      } else {
        x[after ? 2 : 0] = least;
        f[after ? 2 : 0] = value;
      }
    }
    return std::nullopt;
  }

  /// Share at which the law is just broken. An error of the time at which one friction follows the other, to
  /// which it is then equal, counts by its square: to the root of the tolerance.
  double root(double low, double high, double at_low, double at_high) {
    const double enough = enough_;
    for (int i = 0; i < 60 && high - low > enough; ++i) {
      const double fall = at_high - at_low;  // of denormal numbers it may be 0
      double middle = fall < 0.0 ? (low * at_high - high * at_low) / fall : 0.5 * (low + high);
      // Beyond the root by half of what is enough, so that the bracket closes from above.
      middle = std::min(middle + 0.4 * enough, high - 0.25 * enough);
      if (i % 4 == 3 || !(middle > low)) middle = 0.5 * (low + high);
      const double value = law_on(middle);
      if (value > 0.0) {
        low = middle;
        at_low = value;
        at_high *= 0.5;
      } else {
        high = middle;
        at_high = value;
        at_low *= 0.5;
      }
    }
    return high;
  }

  const CollocationConstants& c_;
  double tolerance_, enough_;
  alignas(16) typename GaussLegendre<n>::Points law_, hold_, limit_;
  std::array<double, n> coefficient_;
  double start_law_ = 0.0, noise_ = 0.0;
  bool just_switched_ = false, grips_ = false;
};

}  // namespace strobe::impact::detail
