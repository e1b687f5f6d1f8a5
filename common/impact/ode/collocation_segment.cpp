#include "common/impact/ode/collocation_segment.hpp"

namespace strobe::impact::detail {

namespace {

struct Integrals {
  double couple = 0.0, cosine = 0.0, sine = 0.0;
};

/// Of the polynomials from the segment's start to the share `c` of it: of all three only where it grips, a
/// slipping one has no others.
Integrals integrals(const Segment& segment, double c) {
  const double t = 2.0 * c - 1.0;
  const bool grips = segment.mode == ContactMode::grips;
  Integrals sum{segment.couple[0] * c, grips ? segment.cosine[0] * c : 0.0,
                grips ? segment.sine[0] * c : 0.0};
  double before = 1.0, at = t;
  for (std::size_t k = 1; k < segment.nodes; ++k) {
    const auto degree = static_cast<double>(k);
    const double next = ((2.0 * degree + 1.0) * t * at - degree * before) / (degree + 1.0);
    const double integral = (next - before) / (2.0 * (2.0 * degree + 1.0));
    sum.couple += segment.couple[k] * integral;
    if (grips) {
      sum.cosine += segment.cosine[k] * integral;
      sum.sine += segment.sine[k] * integral;
    }
    before = at;
    at = next;
  }
  return sum;
}

}  // namespace

SegmentPoint point_on(const CollocationConstants& c, const Segment& segment, double x) {
  const TangentialState& start = segment.start;
  SegmentPoint out;
  out.normal = c.normal.at(c.normal.tau(x));
  const Integrals sum = integrals(segment, (x - segment.x) / segment.size);
  const double elapsed = out.normal.tau - segment.from.tau;
  TangentialState& z = out.tangential;
  z.couple = start.couple + sum.couple;
  if (segment.mode == ContactMode::grips) {
    const Grip grip =
        grip_at(c, start, std::exp(-c.b * elapsed), oscillation(c.omega2, elapsed), sum.cosine, sum.sine);
    z.slip = grip.slip;
    z.stretch = grip.stretch;
    z.friction = start.friction +
                 ((grip.slip - start.slip) - c.system.along * elapsed - sum.couple / c.system.alpha) / c.beta;
    return out;
  }
  const double sign = direction(segment.mode);
  z.friction =
      start.friction - sign * c.system.mu * (c.normal.impulse(out.normal) - c.normal.impulse(segment.from));
  z.slip = start.slip + (c.beta * (z.friction - start.friction) + sum.couple / c.system.alpha) +
           c.system.along * elapsed;
  z.stretch = c.slipping_stretch(out.normal, sign);
  if (c.kappa > 0.0)
    z.stretch += std::exp(-c.kappa * elapsed) * (start.stretch - c.slipping_stretch(segment.from, sign));
  return out;
}

SegmentPoint whole_point_on(const CollocationConstants& c, const Segment& segment, double x) {
  SegmentPoint out = point_on(c, segment, x);
  const TangentialState& start = segment.start;
  TangentialState& z = out.tangential;
  const double elapsed = out.normal.tau - segment.from.tau;
  // The couple's impulse is a polynomial of the rule's degree, so the rule integrates it over time exactly.
  const RuleView rule = rule_of(segment);
  double couple = 0.0;
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double at = segment.x + (x - segment.x) * rule.node[i];
    couple += rule.weight[i] * (x - segment.x) * c.normal.pace(at) *
              integrals(segment, (at - segment.x) / segment.size).couple;
  }
  double path = start.friction * elapsed;
  if (segment.mode == ContactMode::grips) {
    path += ((z.stretch - start.stretch) - (start.slip + 0.5 * c.system.along * elapsed) * elapsed -
             couple / c.system.alpha) /
            c.beta;
  } else {
    const double impulse = c.normal.impulse(segment.from);
    path -= direction(segment.mode) * c.system.mu *
            ((c.normal.impulse_integral(out.normal) - c.normal.impulse_integral(segment.from)) -
             impulse * elapsed);
  }
  z.path = start.path + path;
  z.angle = start.angle + (start.couple * elapsed + couple + path) / c.system.alpha;
  return out;
}

TangentialRates rates_at(const CollocationConstants& c, ContactMode mode, const SegmentPoint& point) {
  const TangentialState& t = point.tangential;
  const double spin = c.spin(t);
  return rates_at(c, mode,
                  NodeSample{0.0, c.normal.force(point.normal), c.normal.force_rate(point.normal),
                             c.couple_rate(point.normal, spin), t.slip, t.stretch, spin});
}

TangentialRates rates_at(const CollocationConstants& c, ContactMode mode, const NodeSample& sample) {
  const System& s = c.system;
  const double couple = sample.couple_rate / s.alpha;
  if (mode == ContactMode::grips)
    return {sample.slip, couple - c.beta * (s.kt * sample.stretch + s.ct * sample.slip) + s.along,
            sample.couple_rate};
  const double friction = direction(mode) * s.mu * sample.force;
  const double stretch = s.ct > 0.0 ? c.kappa * (friction / s.kt - sample.stretch)
                                    : direction(mode) * s.mu * sample.force_rate / s.kt;
  return {stretch, couple - c.beta * friction + s.along, sample.couple_rate};
}

RuleView rule_of(const Segment& segment) {
  if (segment.nodes == 8) return {kGaussLegendre<8>.node, kGaussLegendre<8>.weight};
  return {kGaussLegendre<12>.node, kGaussLegendre<12>.weight};
}

}  // namespace strobe::impact::detail
