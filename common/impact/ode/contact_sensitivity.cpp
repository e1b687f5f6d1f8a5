#include "common/impact/ode/contact_sensitivity.hpp"

#include <limits>

#include "common/impact/ode/contact_collocation.hpp"
#include "common/impact/ode/contact_integrator.hpp"
#include "common/impact/ode/variational_equations.hpp"

namespace strobe::impact {

namespace {

using detail::Partials;
using detail::System;

using InputRow = std::array<double, kContactInputs>;

constexpr std::size_t index(ContactInput input) { return static_cast<std::size_t>(input); }

/// Of the changes of vx and w since touchdown, by the dimensionless inputs.
struct ReleasePartials {
  ContactMethod method = ContactMethod::collocation;
  Partials vx{}, spin{};
};

ReleasePartials by_variation(const detail::CollocationConstants& c, const detail::CollocatedContact& contact,
                             const detail::Segments& segments) {
  detail::VariationalEquations equations(c);
  for (std::size_t k = 0; k < segments.count; ++k) {
    const detail::Segment& segment = segments.all[k];
    equations.advance(segment);
    if (k + 1 < segments.count && segments.all[k + 1].mode != segment.mode)
      equations.change_law(segment, segments.all[k + 1].mode);
  }
  const System& s = c.system;
  const detail::NormalState normal = c.normal.at(contact.tau);
  const detail::TangentialPartials& at = equations.partials();
  ReleasePartials out;
  out.vx = at.friction;
  out.vx[detail::kByAlong] += contact.tau;
  // The release comes when the force has gone: N + dN/dt·dtau = 0. Then neither friction nor couple act.
  out.vx[detail::kByGravity] -=
      s.along * (detail::normal_partials(s, normal).force / c.normal.force_rate(normal));
  for (std::size_t k = 0; k < detail::kSystemInputs; ++k)
    out.spin[k] = (at.couple[k] + at.friction[k]) / s.alpha;
  out.spin[detail::kByAlpha] -= c.spin_change(contact.release) / s.alpha;
  return out;
}

/// The inputs of a System in the order of SystemInput.
double& input(System& s, std::size_t k) {
  double* const all[] = {&s.gravity, &s.mu, &s.kt, &s.ct, &s.alpha, &s.delta, &s.w_ref, &s.radius, &s.along};
  return *all[k];
}

/// What a change of the input is small against.
double scale_of(const System& s, std::size_t k) {
  switch (k) {
    case detail::kByKt:
      return s.kt;
    case detail::kByAlpha:
      return s.alpha;
    case detail::kByReference:
      return s.w_ref;
    case detail::kByRadius:
      return s.radius;
    case detail::kByMu:
      return std::hypot(s.mu, 0.01);
    case detail::kByCt:
      return std::hypot(s.ct, 0.1);
    default:
      return 0.1;
  }
}

/// Changes of vx and w since touchdown.
struct Change {
  double vx = 0.0, spin = 0.0;
};

tl::expected<Change, InputError> integrated(System s, const ContactOptions& options) {
  s.vx0 = 0.0;  // of no effect but on the sums
  return detail::integrate(s, options, nullptr).map([&s](const ContactSummary& out) {
    return Change{out.lift_off.vx_mps / s.speed_mps,
                  out.lift_off.omega_radps * s.radius_m / s.speed_mps - s.w0};
  });
}

/// Central differences; at the end of a range those of second order from within.
tl::expected<ReleasePartials, InputError> by_differences(const System& system,
                                                         const ContactOptions& options) {
  constexpr double kStep = 3e-5;
  const auto middle = integrated(system, options);
  if (!middle) return tl::unexpected(middle.error());
  ReleasePartials out{.method = ContactMethod::dormand_prince};
  for (std::size_t k = 0; k < detail::kSystemInputs; ++k) {
    System moved = system;
    const double value = input(moved, k);
    // A dashpot that holds the stretch back for a small part of the contact would take too many steps.
    const double h = k == detail::kByCt && value == 0.0 ? 1e-3 : kStep * scale_of(system, k);
    const bool ends_at_zero = k == detail::kByMu || k == detail::kByCt || k == detail::kByDelta;
    const bool at_end = ends_at_zero && value < h;
    const auto at = [&](double step) {
      input(moved, k) = value + step;
      return integrated(moved, options);
    };
    const auto one = at(h), other = at(at_end ? 2.0 * h : -h);
    if (!one || !other) return tl::unexpected(one ? other.error() : one.error());
    const auto slope = [&](double Change::*number) {
      const double a = (*one).*number, b = (*other).*number, m = (*middle).*number;
      return at_end ? (4.0 * (a - m) - (b - m)) / (2.0 * h) : (a - b) / (2.0 * h);
    };
    out.vx[k] = slope(&Change::vx);
    out.spin[k] = slope(&Change::spin);
  }
  return out;
}

tl::expected<ReleasePartials, InputError> release_partials(const System& system,
                                                           const ContactOptions& options) {
  if (detail::collocates(options)) {
    if (const auto constants = detail::CollocationConstants::make(system)) {
      detail::Segments segments;
      if (const auto contact = detail::collocate(*constants, options.tolerance, false, &segments))
        return by_variation(*constants, *contact, segments);
    }
  }
  return by_differences(system, options);
}

/// How the dimensionless inputs follow from the physical ones.
struct InputScales {
  std::array<InputRow, detail::kSystemInputs> by{};

  InputScales(const System& s, const ContactCoefficients& c) {
    using enum ContactInput;
    const double v = s.speed_mps, f = s.frequency_radps;
    by[detail::kByMu][index(mu)] = 1.0;
    by[detail::kByKt][index(stiffness_ratio)] = 1.0;
    by[detail::kByCt][index(stiffness_ratio)] = 0.5 * s.ct / s.kt;
    by[detail::kByCt][index(damping_ratio)] = std::sqrt(s.kt);
    by[detail::kByAlpha][index(alpha)] = 1.0;
    by[detail::kByDelta][index(offset_share)] = 1.0;
    by[detail::kByReference][index(offset_reference_mps)] = 1.0 / v;
    const double frequency = -f / c.dwell_s;
    by[detail::kByRadius][index(dwell_s)] = s.radius * frequency / f;
    by[detail::kByGravity][index(dwell_s)] = -(s.gravity * frequency / f);
    by[detail::kByAlong][index(dwell_s)] = -(s.along * frequency / f);
  }

  InputRow of(const Partials& partials, double unit) const {
    InputRow row{};
    for (std::size_t q = 0; q < detail::kSystemInputs; ++q)
      for (std::size_t k = 0; k < kContactInputs; ++k) row[k] += unit * partials[q] * by[q][k];
    return row;
  }
};

}  // namespace

tl::expected<ContactSensitivity, InputError> lift_off_sensitivity(const ball::Ball& ball,
                                                                  const Motion& touchdown,
                                                                  const ContactCoefficients& c,
                                                                  const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, c);
  if (!system) return tl::unexpected(system.error());
  return release_partials(*system, options).map([&](const ReleasePartials& p) {
    const InputScales scales(*system, c);
    ContactSensitivity out{.method = p.method,
                           .vx_mps = scales.of(p.vx, system->speed_mps),
                           .omega_radps = scales.of(p.spin, system->speed_mps / system->radius_m)};
    const bool unresolved = c.offset_share == 0.0 && p.method == ContactMethod::collocation;
    if (unresolved)
      out.vx_mps[index(ContactInput::offset_share)] = out.omega_radps[index(ContactInput::offset_share)] =
          std::numeric_limits<double>::quiet_NaN();
    return out;
  });
}

}  // namespace strobe::impact
