#include "common/impact/ode/contact_sensitivity.hpp"

#include "common/impact/ode/contact_collocation.hpp"
#include "common/impact/ode/release_partials.hpp"

namespace strobe::impact {

namespace {

using detail::Partials;
using detail::System;

using InputRow = std::array<double, kContactInputs>;

constexpr std::size_t index(ContactInput input) { return static_cast<std::size_t>(input); }

/// How the dimensionless inputs and the unit of time follow from the physical ones.
struct InputScales {
  std::array<InputRow, detail::kSystemInputs> by{};
  InputRow frequency{};

  InputScales(const System& s, const Motion& touchdown, const ContactCoefficients& c) {
    using enum ContactInput;
    const double v = s.speed_mps, f = s.frequency_radps, radius = s.radius_m;
    const detail::SpringPartials spring = detail::spring_partials(s);
    by[detail::kByZeta][index(e)] = spring.zeta_by_e;
    frequency[index(e)] = f * spring.phase_by_e;
    frequency[index(dwell_s)] = -f / c.dwell_s;
    by[detail::kByMu][index(mu)] = 1.0;
    by[detail::kByKt][index(stiffness_ratio)] = 1.0;
    by[detail::kByCt][index(stiffness_ratio)] = 0.5 * s.ct / s.kt;
    by[detail::kByCt][index(damping_ratio)] = std::sqrt(s.kt);
    by[detail::kByAlpha][index(alpha)] = 1.0;
    by[detail::kByDelta][index(offset_share)] = 1.0;
    by[detail::kByReference][index(offset_reference_mps)] = 1.0 / v;
    by[detail::kByRadius][index(diameter_m)] = 0.5 * f / v;
    by[detail::kByGravity][index(gravity_mps2)] = 1.0 / (f * v);
    by[detail::kByAlong][index(gravity_along_mps2)] = 1.0 / (f * v);
    by[detail::kBySlip][index(vx_mps)] = 1.0 / v;
    for (const auto q : {detail::kBySlip, detail::kBySpin}) {
      by[q][index(omega_radps)] = radius / v;
      by[q][index(diameter_m)] = 0.5 * touchdown.omega_radps / v;
    }
    for (const InputRow row = frequency; const auto k : {index(e), index(dwell_s)}) {
      by[detail::kByRadius][k] += s.radius * row[k] / f;
      by[detail::kByGravity][k] -= s.gravity * row[k] / f;
      by[detail::kByAlong][k] -= s.along * row[k] / f;
    }
    // All of them go with 1/|vy|.
    const std::size_t vy = index(vy_mps);
    by[detail::kByReference][vy] = s.w_ref / v;
    by[detail::kByRadius][vy] = s.radius / v;
    by[detail::kByGravity][vy] = s.gravity / v;
    by[detail::kByAlong][vy] = s.along / v;
    by[detail::kBySlip][vy] = s.slip0 / v;
    by[detail::kBySpin][vy] = s.w0 / v;
  }

  InputRow of(const Partials& partials, double unit) const {
    InputRow row{};
    for (std::size_t q = 0; q < detail::kSystemInputs; ++q)
      for (std::size_t k = 0; k < kContactInputs; ++k) row[k] += unit * partials[q] * by[q][k];
    return row;
  }
};

void add(InputRow& to, const InputRow& what, double times) {
  for (std::size_t k = 0; k < kContactInputs; ++k) to[k] += times * what[k];
}

/// From the dimensionless derivatives to those of ContactSensitivity.
void fill_derivative(const System& s, const Motion& touchdown, const ContactCoefficients& c,
                     const detail::ReleasePartials& p, ContactSensitivity& out) {
  using enum ContactInput;
  const InputScales scales(s, touchdown, c);
  const double v = s.speed_mps, f = s.frequency_radps, radius = s.radius_m, metre = v / f;
  const detail::ReleaseState& at = p.state;
  auto& [vx, vy, omega, dwell, distance, rotation] = out.derivative;
  const std::size_t of_vx = index(vx_mps), of_vy = index(vy_mps), of_omega = index(omega_radps),
                    of_diameter = index(diameter_m);
  vx = scales.of(p.vx, v);
  vx[of_vx] += 1.0;
  vx[of_vy] -= at.vx;
  vy = scales.of(p.rate, -v);
  vy[of_vy] += at.rate;
  omega = scales.of(p.spin, v / radius);
  omega[of_omega] += 1.0;
  omega[of_vy] -= at.spin / radius;
  omega[of_diameter] -= 0.5 * v * at.spin / (radius * radius);
  dwell = scales.of(p.tau, 1.0 / f);
  add(dwell, scales.frequency, -at.tau / (f * f));
  distance = scales.of(p.path, metre);
  rotation = scales.of(p.angle, metre / radius);
  // Both lengths go with the unit of length, and have the share of the touchdown's motion over the dwell time.
  const double rotated = metre * at.angle / radius;
  add(distance, scales.frequency, -metre * at.path / f);
  add(rotation, scales.frequency, -rotated / f);
  distance[of_vy] -= at.path / f;
  rotation[of_vy] -= at.angle / (f * radius);
  rotation[of_diameter] -= 0.5 * rotated / radius;
  add(distance, dwell, touchdown.vx_mps);
  add(rotation, dwell, touchdown.omega_radps);
  distance[of_vx] += at.tau / f;
  rotation[of_omega] += at.tau / f;
}

ContactKink kink_of(const System& s, const Motion& touchdown) {
  if (s.mu == 0.0 && s.slip0 == 0.0) return ContactKink::frictionless_rest;
  if (s.ahead != 0.0 && s.delta > 0.0 && touchdown.vx_mps == 0.0) return ContactKink::offset_turns_round;
  return ContactKink::none;
}

}  // namespace

tl::expected<ContactSensitivity, InputError> lift_off_with_sensitivity(const ball::Ball& ball,
                                                                       const Motion& touchdown,
                                                                       const ContactCoefficients& c,
                                                                       const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, c);
  if (!system) return tl::unexpected(system.error());
  const auto solved = detail::release_partials(*system, options);
  if (!solved) return tl::unexpected(solved.error());
  ContactSensitivity out;
  out.contact = solved->contact;
  out.kink = kink_of(*system, touchdown);
  fill_derivative(*system, touchdown, c, *solved, out);
  return out;
}

}  // namespace strobe::impact
