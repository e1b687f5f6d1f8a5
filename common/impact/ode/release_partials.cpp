#include "common/impact/ode/release_partials.hpp"

#include "common/impact/ode/collocation_summary.hpp"
#include "common/impact/ode/contact_integrator.hpp"
#include "common/impact/ode/couple_pieces.hpp"
#include "common/impact/ode/normal_spring.hpp"

namespace strobe::impact::detail {

namespace {

ReleasePartials by_variation(const CollocationConstants& c, const CollocatedContact& contact,
                             const Segments& segments, double tolerance) {
  VariationalEquations equations(c);
  for (std::size_t k = 0; k < segments.count; ++k) {
    const Segment& segment = segments.all[k];
    if (c.system.delta == 0.0)
      advance_in_pieces(equations, c, segment, tolerance);
    else
      equations.advance(segment);
    if (k + 1 < segments.count && segments.all[k + 1].mode != segment.mode)
      equations.change_law(segment, segments.all[k + 1].mode);
  }
  const System& s = c.system;
  const TangentialState& end = contact.release;
  const double tau = contact.tau;
  // To all digits: what it does to the dwell time, the speeds of touchdown multiply.
  const NormalState normal = c.normal.at(tau);
  const TangentialPartials& at = equations.partials();
  const NormalPartials by = normal_partials(s, normal);
  ReleasePartials out;
  out.contact = lift_off_of(c, contact);
  out.state = {tau,      contact.rate, c.vx_change(end, tau), c.spin_change(end), c.path_change(end, tau),
               end.angle};
  // The release comes when the force has gone: N + dN/dt·dtau = 0. Then neither friction nor couple act.
  const double force_rate = c.normal.force_rate(normal);
  out.tau[kByZeta] = -by.zeta.force / force_rate;
  out.tau[kByGravity] = -by.gravity.force / force_rate;
  out.rate[kByZeta] = by.zeta.rate;
  out.rate[kByGravity] = by.gravity.rate;
  out.vx = at.friction;
  out.vx[kByAlong] += tau;
  out.path = at.path;
  out.path[kByAlong] += 0.5 * tau * tau;
  for (std::size_t k = 0; k < kSystemInputs; ++k) {
    out.rate[k] += s.gravity * out.tau[k];
    out.vx[k] += s.along * out.tau[k];
    out.spin[k] = (at.couple[k] + at.friction[k]) / s.alpha;
    out.path[k] += out.state.vx * out.tau[k];
    out.angle[k] = (at.couple_integral[k] + at.path[k]) / s.alpha + out.state.spin * out.tau[k];
  }
  out.spin[kByAlpha] -= out.state.spin / s.alpha;
  out.angle[kByAlpha] -= end.angle / s.alpha;
  return out;
}

/// The inputs of a System in the order of SystemInput.
double& input(System& s, std::size_t k) {
  double* const all[] = {&s.zeta,  &s.gravity, &s.mu,     &s.kt,    &s.ct,    &s.alpha,
                         &s.delta, &s.w_ref,   &s.radius, &s.along, &s.slip0, &s.w0};
  return *all[k];
}

/// What a change of the input is small against.
double scale_of(const System& s, std::size_t k) {
  switch (k) {
    case kByKt:
      return s.kt;
    case kByAlpha:
      return s.alpha;
    case kByReference:
      return s.w_ref;
    case kByRadius:
      return s.radius;
    case kBySpin:
      return std::hypot(s.w0, std::min(s.w_ref, 1.0));
    case kBySlip:
      return std::hypot(s.slip0, 0.1);
    case kByZeta:
      return std::hypot(s.zeta, 0.1);
    case kByMu:
      return std::hypot(s.mu, 0.01);
    case kByCt:
      return std::hypot(s.ct, 0.1);
    default:
      return 0.1;
  }
}

tl::expected<ReleaseState, InputError> integrated(System s, const ContactOptions& options) {
  s.vx0 = 0.0;  // of no effect but on the sums
  return integrate(s, options, nullptr).map([&s](const ContactSummary& out) {
    const double v = s.speed_mps, f = s.frequency_radps, tau = out.dwell_s * f;
    const double angle = out.rotation_rad * s.radius_m * f / v;
    return ReleaseState{tau,
                        -out.lift_off.vy_mps / v,
                        out.lift_off.vx_mps / v,
                        out.lift_off.omega_radps * s.radius_m / v - s.w0,
                        out.dwell_distance_m * f / v,
                        angle - s.w0 * tau};
  });
}

/// Central differences; at the end of a range those of second order from within.
tl::expected<ReleasePartials, InputError> by_differences(const System& system,
                                                         const ContactOptions& options) {
  constexpr double kStep = 3e-5;
  const auto contact = integrate(system, options, nullptr);
  if (!contact) return tl::unexpected(contact.error());
  const auto middle = integrated(system, options);
  if (!middle) return tl::unexpected(middle.error());
  ReleasePartials out;
  out.contact = lift_off_of(*contact);
  out.state = *middle;
  for (std::size_t k = 0; k < kSystemInputs; ++k) {
    System moved = system;
    const double value = input(moved, k);
    // A dashpot that holds the stretch back for a small part of the contact would take too many steps.
    const double h = k == kByCt && value == 0.0 ? 1e-3 : kStep * scale_of(system, k);
    const bool ends_at_zero = k == kByZeta || k == kByMu || k == kByCt || k == kByDelta;
    const bool at_end = ends_at_zero && value < h;
    const auto at = [&](double step) {
      input(moved, k) = value + step;
      return integrated(moved, options);
    };
    const auto one = at(h), other = at(at_end ? 2.0 * h : -h);
    if (!one || !other) return tl::unexpected(one ? other.error() : one.error());
    const auto slope = [&](double ReleaseState::*number) {
      const double a = (*one).*number, b = (*other).*number, m = (*middle).*number;
      return at_end ? (4.0 * (a - m) - (b - m)) / (2.0 * h) : (a - b) / (2.0 * h);
    };
    out.tau[k] = slope(&ReleaseState::tau);
    out.rate[k] = slope(&ReleaseState::rate);
    out.vx[k] = slope(&ReleaseState::vx);
    out.spin[k] = slope(&ReleaseState::spin);
    out.path[k] = slope(&ReleaseState::path);
    out.angle[k] = slope(&ReleaseState::angle);
  }
  return out;
}

}  // namespace

tl::expected<ReleasePartials, InputError> release_partials(const System& system,
                                                           const ContactOptions& options) {
  if (collocates(options)) {
    if (const auto constants = CollocationConstants::make(system)) {
      Segments segments;
      if (const auto contact = collocate(*constants, options.tolerance, false, &segments))
        return by_variation(*constants, *contact, segments, options.tolerance);
    }
  }
  return by_differences(system, options);
}

SpringPartials spring_partials(const System& system) {
  System free = system;
  free.gravity = 0.0;
  const double tau = release_phase(free.zeta), e = restitution_of_damping_ratio(free.zeta);
  // Where the force has gone: the depth is 2·zeta·e, its rate -e, both dN/dt and the force's change along it as well.
  const NormalPartial by = normal_partials(free, {tau, 2.0 * free.zeta * e, -e}).zeta;
  const double zeta_by_e = -1.0 / by.rate;
  return {zeta_by_e, by.force / e * zeta_by_e / tau};
}

}  // namespace strobe::impact::detail
