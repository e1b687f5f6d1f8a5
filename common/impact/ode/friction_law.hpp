// Implementation of contact_collocation.hpp: the law of friction along a solved segment, positive where it holds, and
// where it is first broken. Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <limits>
#include <optional>

#include "common/impact/ode/segment_solver.hpp"

namespace strobe::impact::detail {

/// Gripping mu·N - |F|; slipping what |F| of a grip would exceed mu·N by, without a dashpot how fast it would.
class FrictionLaw {
 public:
  FrictionLaw(const CollocationConstants& constants, ContactMode mode)
      : c_(constants), s_(constants.system), mode_(mode) {}

  /// Direction of a grip's friction.
  double side_of(double stretch, double slip) const {
    return s_.kt * stretch + s_.ct * slip < 0.0 ? -1.0 : 1.0;
  }

  double value(double force, double force_rate, double stretch, double slip, double side) const {
    if (mode_ == ContactMode::grips) return s_.mu * force - side * (s_.kt * stretch + s_.ct * slip);
    const double sign = direction(mode_);
    if (s_.ct > 0.0) return sign * (s_.kt * stretch + s_.ct * slip) - s_.mu * force;
    return sign * slip - s_.mu * force_rate / s_.kt;
  }

  /// Its rate.
  double rate(const SegmentPoint& point, double side) const {
    const TangentialRates rates = rates_at(c_, mode_, point);
    const double force = c_.normal.force(point.normal), force_rate = c_.normal.force_rate(point.normal);
    const double hold_rate = s_.kt * rates.stretch + s_.ct * rates.slip;
    if (mode_ == ContactMode::grips) return s_.mu * force_rate - side * hold_rate;
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
  void sample(const Segment& segment, const SegmentSolver<n>& solver, const SegmentPoint& end,
              bool just_switched) {
    const FrictionLaw law(c_, segment.mode);
    just_switched_ = just_switched;
    grips_ = segment.mode == ContactMode::grips;
    put(law, 0, 0.0, c_.normal.force(segment.from), c_.normal.force_rate(segment.from), segment.start.stretch,
        segment.start.slip);
    if (just_switched) law_[0] = 0.0;
    const double zeta2 = 2.0 * c_.system.zeta;
    for (std::size_t i = 0; i < n; ++i) {
      const double force = solver.force()[i];
      limit_[i] = c_.system.mu * force;
      put(law, i + 1, kGaussLegendre<n>.node[i], force,
          solver.rate()[i] + zeta2 * (c_.system.gravity - force), solver.stretch()[i], solver.slip()[i]);
    }
    put(law, n + 1, 1.0, c_.normal.force(end.normal), c_.normal.force_rate(end.normal),
        end.tangential.stretch, end.tangential.slip);
    noise_ = law.noise(segment.start, tolerance_);
  }

  double at_end() const { return law_[n + 1]; }
  double side_at_end() const { return side_[n + 1]; }

  /// A mode that has just begun may be broken by as much as the last was not yet when it ended, or was already.
  /// Returns false if it is broken by more before its first node.
  bool accept_start(double switch_law) {
    if (!just_switched_) return true;
    for (std::size_t i = 1; i < n + 2 && law_[i] < 0.0; ++i) {
      if (law_[i] < -(noise_ + switch_law)) return i > 1;
      law_[i] = 0.0;
    }
    return true;
  }

  /// The share of the segment where the law is first broken, by the polynomial through its nodes. Returns nullopt if
  /// it holds throughout.
  std::optional<double> find_event() {
    for (std::size_t i = 1; i < n + 2; ++i) {
      if (law_[i] < -noise_) {
        interpolate_law(i);
        return root(share_[i - 1], share_[i], std::max(law_[i - 1], 0.0), law_[i]);
      }
      if (i < 2) continue;
      if (const auto dip = broken_between(i - 2, i - 1, i)) return dip;
    }
    return std::nullopt;
  }

 private:
  void put(const FrictionLaw& law, std::size_t i, double share, double force, double force_rate,
           double stretch, double slip) {
    share_[i] = share;
    side_[i] = law.side_of(stretch, slip);
    law_[i] = law.value(force, force_rate, stretch, slip, side_[i]);
  }

  /// Legendre coefficients of the law, gripping of that for the side to which it may break: |F| has a kink
  /// where the friction turns round.
  void interpolate_law(std::size_t near) {
    std::array<double, n> value;
    for (std::size_t i = 0; i < n; ++i)
      value[i] = side_[i + 1] == side_[near] || !grips_ ? law_[i + 1] : 2.0 * limit_[i] - law_[i + 1];
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

  /// A minimum between three samples, all of which are lawful.
  std::optional<double> broken_between(std::size_t a, std::size_t b, std::size_t c) {
    if (!(law_[b] < law_[c]) || !(law_[b] < law_[a])) return std::nullopt;
    bool interpolated = false;
    double x[3] = {share_[a], share_[b], share_[c]};
    double f[3] = {law_[a], law_[b], law_[c]};
    for (int round = 0; round < 4; ++round) {
      const double left = (f[1] - f[0]) / (x[1] - x[0]), right = (f[2] - f[1]) / (x[2] - x[1]);
      const double bend = (right - left) / (x[2] - x[0]);
      if (!(bend > 0.0)) return std::nullopt;
      const double least = 0.5 * (x[0] + x[1]) - 0.5 * left / bend;
      if (!(least > x[0] && least < x[2])) return std::nullopt;
      const double fall = bend * (least - x[1]) * (least - x[1]);
      // A dip that does not come near the law is none.
      if (f[1] - 16.0 * fall > 0.5 * std::min(f[0], f[2])) return std::nullopt;
      if (!interpolated) interpolate_law(b);
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

  /// Share at which the law is just broken. An error of the time at which one friction follows the other, to which
  /// it is then equal, counts by its square: to the root of the tolerance.
  double root(double low, double high, double at_low, double at_high) {
    const double enough = enough_;
    for (int i = 0; i < 60 && high - low > enough; ++i) {
      double middle = (low * at_high - high * at_low) / (at_high - at_low);
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
  std::array<double, n + 2> law_, share_, side_;
  std::array<double, n> limit_, coefficient_;
  double noise_ = 0.0;
  bool just_switched_ = false, grips_ = false;
};

}  // namespace strobe::impact::detail
