// One segment of a contact solved by collocation (contact_collocation.hpp): the tangential motion under one
// law of friction, in contact_system.hpp's units, as functions of the only unknown, the impulse D of the
// offset's couple. With P = dvx - g_x·t, which is friction's impulse, alpha·dw - P = D at all times:
//   slipping: P changes by -sigma·mu times the normal impulse; the stretch is that of a spring and dashpot
//     under the damped sine mu·N;
//   gripping: u'' + 2b·u' + (b² + omega2)·u = D'/alpha + g_x, by variation of constants about the stretch
//   that holds
//     the weight.
// Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <algorithm>
#include <span>

#include "common/impact/ode/gauss_legendre.hpp"
#include "common/impact/ode/normal_motion.hpp"

namespace strobe::impact::detail {

inline constexpr std::size_t kMaxNodes = 13;
inline constexpr std::size_t kMaxSegments = 40;

/// As changes since touchdown.
struct TangentialState {
  double couple = 0.0;    ///< D
  double friction = 0.0;  ///< P
  double slip = 0.0;      ///< s = vx + w
  double stretch = 0.0;   ///< u
  double path = 0.0;      ///< integral of P
  double angle = 0.0;     ///< integral of dw
};

/// What all segments of a contact share.
struct CollocationConstants {
  System system;
  NormalMotion normal;
  double beta = 0.0;                                     ///< 1 + 1/alpha
  double b = 0.0;                                        ///< decay of a grip
  double omega2 = 0.0;                                   ///< of a grip
  double kappa = 0.0;                                    ///< k_t/c_t; 0 without a dashpot
  double rest = 0.0;                                     ///< stretch of a grip that holds the weight
  double particular_depth = 0.0, particular_rate = 0.0;  ///< of the stretch under N: g + p·(y - g) + r·y'

  /// Returns nullopt where the closed forms do not hold: a weight that is a large part of the force, or a
  /// dashpot whose stretch decays as the normal force does.
  static std::optional<CollocationConstants> make(const System& system) {
    const auto normal = NormalMotion::make(system);
    if (!normal) return std::nullopt;
    const CollocationConstants c(system, *normal);
    // The particular solution loses as many digits as this is small.
    if (c.kappa > 0.0 && std::abs(c.resonance()) < 0.01) return std::nullopt;
    return c;
  }

  CollocationConstants(const System& s, const NormalMotion& n) : system(s), normal(n) {
    beta = 1.0 + 1.0 / s.alpha;
    b = 0.5 * beta * s.ct;
    omega2 = beta * s.kt - b * b;
    rest = s.along / (beta * s.kt);
    if (s.ct == 0.0) return;
    kappa = s.kt / s.ct;
    const double i = 1.0 / kappa;
    particular_rate = (2.0 * s.zeta - i) / resonance();
    particular_depth = 1.0 + particular_rate * i;
  }

  /// 0 where the stretch under the damped sine has no particular solution of its form: near critical damping.
  double resonance() const {
    const double i = 1.0 / kappa;
    return 1.0 + i * (i - 2.0 * system.zeta);
  }
  double spin_change(const TangentialState& t) const { return (t.couple + t.friction) / system.alpha; }
  double spin(const TangentialState& t) const { return system.w0 + spin_change(t); }
  double vx_change(const TangentialState& t, double tau) const { return t.friction + system.along * tau; }
  /// Integral of that.
  double path_change(const TangentialState& t, double tau) const {
    return t.path + 0.5 * system.along * tau * tau;
  }
  double holding_force(const TangentialState& t) const { return system.kt * t.stretch + system.ct * t.slip; }
  /// d·N/R, the rate of D.
  double couple_rate(const NormalState& n, double spin) const {
    return footprint(n.depth) * normal.force(n) * system.offset_direction(spin);
  }
  double footprint(double depth) const {
    const double share = depth < system.radius ? std::max(depth / system.radius, 0.0) : 1.0;
    return system.delta * std::sqrt(share * (2.0 - share));
  }
  /// The stretch of a spring that slips by `sign`, long after it began to.
  double slipping_stretch(const NormalState& n, double sign) const {
    const double limit = sign * system.mu / system.kt;
    if (kappa == 0.0) return limit * normal.force(n);
    const double g = system.gravity;
    return limit * (g + (particular_depth * (n.depth - g) + particular_rate * n.rate));
  }
};

/// The collocation at a node.
struct NodeSample {
  double weight;  ///< of the node in an integral over time
  double force, force_rate, couple_rate;
  double slip, stretch, spin;
};

struct SegmentPoint {
  NormalState normal;
  TangentialState tangential;
};

struct Segment {
  ContactMode mode = ContactMode::grips;
  double x = 0.0;
  double size = 0.0;
  NormalState from;
  TangentialState start;
  std::size_t nodes = 0;
  /// Legendre coefficients of D' along the segment, per share of it; gripping, of exp(2bt)·W·D' and
  /// exp(2bt)·S·D'.
  std::array<double, kMaxNodes> couple, cosine, sine;
  std::array<NodeSample, kMaxNodes> samples;
  double used = 1.0;  ///< share of it up to where friction changed its law
  SegmentPoint end;   ///< there, by this law
};

/// Sum of a grip's two solutions at the time t after the segment's start, weighted with what variation of
/// constants gives.
struct Grip {
  double stretch;
  double slip;
};

inline Grip grip_at(const CollocationConstants& c, const TangentialState& start, double fade,
                    const Oscillation& o, double cosine_integral, double sine_integral) {
  const double first = (start.stretch - c.rest) - sine_integral / c.system.alpha;
  const double second = start.slip + cosine_integral / c.system.alpha;
  const double sine = fade * o.sine, rate = fade * (o.cosine - c.b * o.sine);
  return {c.rest + (first * (rate + 2.0 * c.b * sine) + second * sine),
          second * rate - first * (c.beta * c.system.kt * sine)};
}

/// The state on a solved segment; path and angle are not computed. At a node it is that of the collocation.
SegmentPoint point_on(const CollocationConstants& c, const Segment& segment, double x);

/// The same with path and angle.
SegmentPoint whole_point_on(const CollocationConstants& c, const Segment& segment, double x);

/// Rates of the stretch, of the slip and of the couple's impulse at a point of a segment.
struct TangentialRates {
  double stretch, slip, couple;
};
TangentialRates rates_at(const CollocationConstants& c, ContactMode mode, const SegmentPoint& point);
TangentialRates rates_at(const CollocationConstants& c, ContactMode mode, const NodeSample& sample);

/// The segments of a contact, without allocation.
struct Segments {
  std::array<Segment, kMaxSegments> all;
  std::size_t count = 0;
};

/// Nodes and weights of the rule that a segment was solved with.
struct RuleView {
  std::span<const double> node, weight;
};
RuleView rule_of(const Segment& segment);

}  // namespace strobe::impact::detail
