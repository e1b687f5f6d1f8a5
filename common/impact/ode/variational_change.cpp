// What a change of the friction's law hands on to the next segment.
#include "common/impact/ode/variational_equations.hpp"

#include <cassert>
#include <utility>

#include "common/impact/ode/friction_law.hpp"

namespace strobe::impact::detail {

VariationalEquations::GripStart VariationalEquations::start_of_grip(const Segment& segment) const {
  const double beta_by_alpha = -1.0 / (s_.alpha * s_.alpha);
  GripStart out;
  out.b[kByCt] = 0.5 * c_.beta;
  out.b[kByAlpha] = 0.5 * s_.ct * beta_by_alpha;
  out.omega2[kByKt] = c_.beta;
  out.omega2[kByAlpha] = s_.kt * beta_by_alpha;
  add(out.omega2, out.b, -2.0 * c_.b);
  out.rest[kByAlong] = 1.0 / (c_.beta * s_.kt);
  out.rest[kByKt] = -c_.rest / s_.kt;
  out.rest[kByAlpha] = -c_.rest * beta_by_alpha / c_.beta;
  out.first = at_.stretch;
  add(out.first, out.rest, -1.0);
  // That with the rate b of the decay is the free grip's own.
  out.second = slip_of(at_, segment.from.tau, c_.spin(segment.start));
  add(out.second, out.first, c_.b);
  return out;
}

Partials VariationalEquations::friction_of(ContactMode mode, const SegmentPoint& end,
                                           const NormalPartials& by) const {
  Partials out{};
  if (mode == ContactMode::grips) {
    add(out, at_.stretch, s_.kt);
    add(out, slip_of(at_, end.normal.tau, c_.spin(end.tangential)), s_.ct);
    out[kByKt] += end.tangential.stretch;
    out[kByCt] += end.tangential.slip;
    return out;
  }
  const double sign = direction(mode);
  out[kByMu] = sign * c_.normal.force(end.normal);
  out[kByGravity] = sign * s_.mu * by.force;
  return out;
}

Partials VariationalEquations::stretch_rate_of(ContactMode mode, const SegmentPoint& end,
                                               const NormalPartials& by, const Partials& friction) const {
  if (mode == ContactMode::grips) return slip_of(at_, end.normal.tau, c_.spin(end.tangential));
  const double sign = direction(mode), force = c_.normal.force(end.normal);
  Partials out{};
  if (s_.ct > 0.0) {
    const double rate = (sign * s_.mu * force - s_.kt * end.tangential.stretch) / s_.ct;
    add(out, friction, 1.0 / s_.ct);
    add(out, at_.stretch, -c_.kappa);
    out[kByKt] -= end.tangential.stretch / s_.ct;
    out[kByCt] -= rate / s_.ct;
    return out;
  }
  const double limit = sign * s_.mu / s_.kt, rate = c_.normal.force_rate(end.normal);
  out[kByMu] = sign * rate / s_.kt;
  out[kByKt] = -limit * rate / s_.kt;
  out[kByCt] = -limit * ((s_.gravity - force) - 2.0 * s_.zeta * rate) / s_.kt;
  out[kByGravity] = limit * by.force_rate;
  return out;
}

void VariationalEquations::change_law(const Segment& segment, ContactMode next) {
  const SegmentPoint& end = segment.end;
  const FrictionLaw law(c_, segment.mode);
  const double rate = law.rate(end);
  if (!(rate < 0.0)) return;
  const double late = law.value(end) / rate;
  const NormalPartials by = normal_partials(s_, end.normal);
  const Partials old_friction = friction_of(segment.mode, end, by), friction = friction_of(next, end, by);
  const Partials old_rate = stretch_rate_of(segment.mode, end, by, old_friction);
  const Partials stretch_rate = stretch_rate_of(next, end, by, friction);
  add(at_.friction, friction, -late);
  add(at_.friction, old_friction, late);
  add(at_.stretch, stretch_rate, late);
  add(at_.stretch, old_rate, -late);
}

void VariationalEquations::advance(const Segment& segment) {
  place_nodes(segment);
  if (segment.mode == ContactMode::grips) {
    const GripStart start = start_of_grip(segment);
    solve_grip(segment, start);
    finish_grip(segment, start);
    return;
  }
  solve_slip(segment);
  finish_slip(segment);
}

}  // namespace strobe::impact::detail
