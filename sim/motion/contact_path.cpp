#include "sim/motion/contact_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/flight/gravity.hpp"
#include "common/impact/ode/normal_spring.hpp"

#include "sim/motion/spatial_course.hpp"
#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

tl::unexpected<Error> refused(impact::InputError error) { return fail(std::string(impact::message(error))); }

/// Length of a pulse from which the ball, released while still flattened by y(1), reaches its radius again
/// after `dwell_s` in all: every length of the pulse scales with its duration.
Result<double> pulse_length_s(impact::PulseInput input, double vy_lo_mps, double dwell_s) {
  input.dwell_s = 1.0;
  const auto unit = impact::SinePulse::make(impact::PulseForm::exact, input);
  if (!unit) return refused(unit.error());
  const double still_flattened_mps = -unit->at_fraction(1.0).y_m;
  return dwell_s / (1.0 + still_flattened_mps / vy_lo_mps);
}

double weight_along_mps2(const Scene& scene) {
  return scene.surface_angle_rad == 0.0 ? 0.0
                                        : -flight::kStandardGravity_mps2 * std::sin(scene.surface_angle_rad);
}

impact::ContactCoefficients ode_coefficients(const Scene& scene, const ShotConditions& thrown,
                                             const Model& model, const impact::NormalSpring& unit) {
  impact::ContactCoefficients c;
  c.e = thrown.coefficients.e;
  // Of the spring that takes one second from touchdown to release.
  c.dwell_s = thrown.dwell_s / (1.0 + 2.0 * unit.damping_ratio / unit.frequency_radps);
  c.mu = thrown.coefficients.mu;
  c.stiffness_ratio = thrown.stiffness_ratio;
  c.damping_ratio = scene.bounce.damping_ratio;
  c.offset_share = model.has(Effect::offset) ? thrown.offset_share : 0.0;
  if (!model.has(Effect::contact_gravity)) return c;
  c.gravity_mps2 = std::max(0.0, flight::kStandardGravity_mps2 * std::cos(scene.surface_angle_rad));
  c.gravity_along_mps2 = weight_along_mps2(scene);
  return c;
}

impact::ContactOptions contact_options(const Model& model,
                                       impact::ContactMethod method = impact::ContactMethod::collocation) {
  return {.method = method, .tolerance = model.contact_tolerance()};
}

}  // namespace

Result<MechanicsInput> mechanics_input(const Scene& scene, const ShotConditions& thrown, const Model& model) {
  const auto unit = impact::normal_spring(scene.ball.mass_kg, thrown.coefficients.e, 1.0);
  if (!unit) return refused(unit.error());
  const auto c = ode_coefficients(scene, thrown, model, *unit);
  return MechanicsInput{c, 2.0 * unit->damping_ratio / unit->frequency_radps * c.dwell_s};
}

Result<LiftOff> risen(const Scene& scene, const impact::Motion& td, const impact::ContactLiftOff& release,
                      double depth_m, const impact::ContactCoefficients& coefficients) {
  const double gravity_mps2 = coefficients.gravity_mps2, along_mps2 = coefficients.gravity_along_mps2;
  LiftOff end;
  impact::Motion& lo = end.rebound.lift_off;
  lo = release.lift_off;
  const double left = lo.vy_mps * lo.vy_mps - 2.0 * gravity_mps2 * depth_m;
  if (!(lo.vy_mps > 0.0) || left <= 0.0) return fail("the ball's weight keeps it on the surface");
  const double free_s = 2.0 * depth_m / (lo.vy_mps + std::sqrt(left));
  lo.vy_mps = std::sqrt(left);
  const double release_mps = release.lift_off.vy_mps;
  end.impulse_factor = (release_mps - td.vy_mps + gravity_mps2 * release.dwell_s) / (lo.vy_mps - td.vy_mps);
  end.dwell_s = release.dwell_s + free_s;
  end.displacement_m = release.dwell_distance_m + (lo.vx_mps + 0.5 * along_mps2 * free_s) * free_s;
  lo.vx_mps += along_mps2 * free_s;
  end.rotation_rad = release.rotation_rad + lo.omega_radps * free_s;
  const double radius = scene.ball.radius_m();
  const double impulse = lo.vy_mps - td.vy_mps;
  end.rebound.regime = release.regime;
  end.rebound.slip_lo_mps = lo.vx_mps + radius * lo.omega_radps;
  end.rebound.impulse_ratio = (td.vx_mps - lo.vx_mps) / impulse;
  end.rebound.offset_m = (scene.ball.alpha * radius * radius * (lo.omega_radps - td.omega_radps) -
                          radius * (lo.vx_mps - td.vx_mps - along_mps2 * end.dwell_s)) /
                         impulse;
  return end;
}

namespace {

/// Friction against the slip as far as `mu` allows, up to what leaves -ex times the slip; a normal force
/// `offset_m` ahead of the centre; a weight along the surface that adds `pull_mps` to vx.
impact::Rebound algebraic(const ball::Ball& ball, const impact::Motion& td, double e, double mu,
                          double offset_m, std::optional<double> ex, double pull_mps) {
  const double radius = ball.radius_m();
  const double impulse = (1.0 + e) * std::abs(td.vy_mps);
  const double slip = td.vx_mps + radius * td.omega_radps;
  const double couple = offset_m / radius * impulse / ball.alpha;
  impact::Rebound out;
  double dvx = slip == 0.0 ? 0.0 : -std::copysign(mu * impulse, slip);
  if (ex) {
    const double gripping = -((1.0 + *ex) * slip + couple + pull_mps) / (1.0 + 1.0 / ball.alpha);
    out.regime = std::abs(gripping) <= mu * impulse ? Regime::grips : Regime::slides;
    dvx = std::clamp(gripping, -mu * impulse, mu * impulse);
  }
  out.lift_off = {td.vx_mps + (dvx + pull_mps), e * std::abs(td.vy_mps),
                  td.omega_radps + (dvx / ball.alpha + couple) / radius};
  out.slip_lo_mps = out.lift_off.vx_mps + radius * out.lift_off.omega_radps;
  out.impulse_ratio = -(dvx + pull_mps) / impulse;
  out.offset_m = offset_m;
  return out;
}

Result<LiftOff> reduced_lift_off(const Scene& scene, const ShotConditions& thrown, const Model& model,
                                 const ReducedContact& c) {
  const double mean_share = scene.bounce.offset_share;
  const double offset = mean_share > 0.0 ? c.offset_m * thrown.offset_share / mean_share : c.offset_m;
  const double e = std::min(1.0, c.e_factor * thrown.coefficients.e);
  LiftOff end;
  end.dwell_s = c.dwell_factor * thrown.dwell_s;
  const double pull_mps = model.has(Effect::contact_gravity) ? weight_along_mps2(scene) * end.dwell_s : 0.0;
  end.rebound = algebraic(scene.ball, thrown.touchdown, e, c.impulse_factor * thrown.coefficients.mu, offset,
                          model.has(Effect::grip) ? std::optional(c.ex) : std::nullopt, pull_mps);
  const auto plain = SinePath::make(scene, thrown.touchdown, end);
  if (!plain) return tl::unexpected(plain.error());
  const LiftOff sine = plain->plain_end();
  const double scale_m = (end.rebound.lift_off.vy_mps - thrown.touchdown.vy_mps) * end.dwell_s;
  end.displacement_m = sine.displacement_m + c.displacement_shift * scale_m;
  end.rotation_rad = sine.rotation_rad + c.rotation_shift * scale_m / scene.ball.radius_m();
  return end;
}

/// contact = "grip".
Result<LiftOff> grip_lift_off(const Scene& scene, const ShotConditions& thrown, const Model& model) {
  impact::Coefficients c = thrown.coefficients;
  if (!model.has(Effect::offset)) c.offset_m = 0.0;
  const auto rebound = impact::grip(scene.ball, thrown.touchdown, c);
  if (!rebound) return refused(rebound.error());
  LiftOff end;
  end.rebound = model.has(Effect::grip) ? *rebound
                                        : algebraic(scene.ball, thrown.touchdown, c.e, c.mu,
                                                    rebound->offset_m, std::nullopt, 0.0);
  end.dwell_s = thrown.dwell_s;
  const auto plain = SinePath::make(scene, thrown.touchdown, end);
  if (!plain) return tl::unexpected(plain.error());
  const LiftOff sine = plain->plain_end();
  end.displacement_m = sine.displacement_m;
  end.rotation_rad = sine.rotation_rad;
  return end;
}

bool ode_is_asked(const Scene& scene, const Model& model) {
  return scene.bounce.contact == ContactLaw::ode && model.has(Effect::grip) &&
         model.has(Effect::tangential_compliance);
}

/// Smallest stiffness ratio after a draw.
constexpr double kMinStiffnessRatio = 0.01;
constexpr double kMinRestitution = 0.05, kMaxRestitution = 0.99;

/// Turns the way along the surface out of the plane, and adds the spins that are not across it.
void throw_aside(const MachineSettings& m, Draws draws, ShotConditions& t) {
  const double along_mps = t.touchdown.vx_mps;
  const double lateral_rad = draws.normal(m.lateral_rad, m.lateral_sd_rad);
  t.touchdown.vx_mps = along_mps * std::cos(lateral_rad);
  t.vz_mps = along_mps * std::sin(lateral_rad);
  t.omega_y_radps = draws.normal(m.sidespin_radps, m.sidespin_sd_radps);
  t.omega_x_radps = draws.normal(m.gyrospin_radps, m.gyrospin_sd_radps);
}

}  // namespace

ShotConditions draw_shot_conditions(const Scene& scene, std::uint64_t seed, int shot) {
  const MachineSettings& m = scene.machine;
  const BounceSettings& b = scene.bounce;
  const auto number = static_cast<std::uint64_t>(shot);
  Draws machine(seed, Purpose::machine, number);
  const double speed = std::max(0.5, machine.normal(m.speed_mps, m.speed_sd_mps));
  const double angle =
      std::clamp(machine.normal(m.angle_rad, m.angle_sd_rad), -0.5 * std::numbers::pi, -0.03);

  ShotConditions t;
  t.touchdown = {speed * std::cos(angle), speed * std::sin(angle),
                 machine.normal(m.spin_radps, m.spin_sd_radps)};
  t.lag_s = std::max(0.001, machine.normal(m.lag_s, m.lag_sd_s));
  t.spot_m = machine.normal(0.0, m.spot_sd_m);
  t.equator_rad = machine.uniform() * std::numbers::pi;
  if (!m.planar()) throw_aside(m, Draws(seed, Purpose::out_of_plane, number), t);
  t.off_plane_m = Draws(seed, Purpose::off_plane, number).normal(0.0, scene.camera.off_plane_sd_m);

  Draws bounce(seed, Purpose::bounce, number);
  const double e_mean = b.e + b.e_slope_spm * (std::abs(t.touchdown.vy_mps) - b.e_speed_mps);
  t.coefficients.e = std::clamp(bounce.normal(e_mean, b.e_sd), kMinRestitution, kMaxRestitution);
  const double grip = bounce.normal();
  const double rho = b.offset_grip_correlation;
  const double offset = rho * grip + std::sqrt(1.0 - rho * rho) * bounce.normal();
  t.coefficients.mu = std::max(0.0, b.mu + b.mu_sd * grip);
  t.coefficients.e_x = std::clamp(b.ex + b.ex_sd * grip, -1.0, 1.0);
  t.coefficients.offset_m = std::clamp(b.offset_m + b.offset_sd_m * offset, 0.0, 0.9 * scene.ball.radius_m());
  t.stiffness_ratio = std::clamp(b.stiffness_ratio + b.stiffness_ratio_sd * grip, kMinStiffnessRatio, 1e3);
  t.offset_share = std::clamp(b.offset_share + b.offset_share_sd * offset, 0.0, 1.0);
  t.dwell_s = std::clamp(bounce.normal(b.dwell_s, b.dwell_sd_s), 0.5 * b.dwell_s, 1.5 * b.dwell_s);
  return t;
}

ShotConditions conditions_of_next_bounce(const Scene& scene, const ShotConditions& before,
                                         const impact::Motion& touchdown) {
  ShotConditions next = before;
  next.touchdown = touchdown;
  const double faster_mps = std::abs(touchdown.vy_mps) - std::abs(before.touchdown.vy_mps);
  next.coefficients.e = std::clamp(before.coefficients.e + scene.bounce.e_slope_spm * faster_mps,
                                   kMinRestitution, kMaxRestitution);
  return next;
}

Scene without_spread(Scene scene) {
  MachineSettings& m = scene.machine;
  m.speed_sd_mps = m.angle_sd_rad = m.spin_sd_radps = m.lag_sd_s = m.spot_sd_m = 0.0;
  m.lateral_sd_rad = m.sidespin_sd_radps = m.gyrospin_sd_radps = 0.0;
  BounceSettings& b = scene.bounce;
  b.e_sd = b.mu_sd = b.dwell_sd_s = b.ex_sd = b.stiffness_ratio_sd = 0.0;
  b.offset_sd_m = b.offset_share_sd = 0.0;
  scene.camera.off_plane_sd_m = 0.0;
  return scene;
}

bool needs_calibration(const Scene& scene, const Model& model) {
  return scene.bounce.contact == ContactLaw::ode && !ode_is_asked(scene, model);
}

Result<LiftOff> ode_lift_off(const Scene& scene, const ShotConditions& thrown, const Model& model,
                             impact::ContactMethod method) {
  const auto input = mechanics_input(scene, thrown, model);
  if (!input) return tl::unexpected(input.error());
  const auto release =
      impact::lift_off(scene.ball, thrown.touchdown, input->coefficients, contact_options(model, method));
  if (!release) return refused(release.error());
  return risen(scene, thrown.touchdown, *release, input->still_compressed_s * release->lift_off.vy_mps,
               input->coefficients);
}

Result<ReducedContact> calibrate(const Scene& scene, const Model& model) {
  const ShotConditions mean = draw_shot_conditions(without_spread(scene), 1, 1);
  const auto end = ode_lift_off(scene, mean, model);
  if (!end) return tl::unexpected(end.error());
  const impact::Motion& td = mean.touchdown;
  const impact::Motion& lo = end->rebound.lift_off;
  const double slip_td = td.vx_mps + scene.ball.radius_m() * td.omega_radps;
  ReducedContact c;
  // If the mean ball slides, or hardly slips, it determines no e_x.
  c.ex = scene.bounce.ex;
  if (end->rebound.regime == Regime::grips && std::abs(slip_td) > std::abs(end->rebound.slip_lo_mps))
    c.ex = -end->rebound.slip_lo_mps / slip_td;
  c.offset_m = end->rebound.offset_m;
  c.e_factor = -lo.vy_mps / td.vy_mps / mean.coefficients.e;
  c.impulse_factor = end->impulse_factor;
  c.dwell_factor = end->dwell_s / mean.dwell_s;
  const auto sine = SinePath::make(scene, td, *end);
  if (!sine) return tl::unexpected(sine.error());
  const LiftOff plain = sine->plain_end();
  const double scale_m = (lo.vy_mps - td.vy_mps) * end->dwell_s;
  c.displacement_shift = (end->displacement_m - plain.displacement_m) / scale_m;
  c.rotation_shift = (end->rotation_rad - plain.rotation_rad) * scene.ball.radius_m() / scale_m;
  return c;
}

Result<SinePath> SinePath::make(const Scene& scene, const impact::Motion& touchdown, const LiftOff& end) {
  impact::PulseInput input{.vx_td_mps = touchdown.vx_mps,
                           .vy_td_mps = touchdown.vy_mps,
                           .e = std::min(1.0, -end.rebound.lift_off.vy_mps / touchdown.vy_mps),
                           .impulse_ratio = end.rebound.impulse_ratio,
                           .dwell_s = end.dwell_s,
                           .mass_kg = scene.ball.mass_kg};
  const auto length_s = pulse_length_s(input, end.rebound.lift_off.vy_mps, end.dwell_s);
  if (!length_s) return tl::unexpected(length_s.error());
  input.dwell_s = *length_s;
  const auto pulse = impact::SinePulse::make(impact::PulseForm::exact, input);
  if (!pulse) return refused(pulse.error());
  return SinePath(touchdown, end, *pulse);
}

SinePath::Plain SinePath::plain_at(double time_s) const {
  const double length_s = pulse_.input().dwell_s;
  const double pushed_s = std::min(time_s, length_s);
  const impact::Motion& lo = end_.rebound.lift_off;
  Plain out{.pulse = pulse_.at_time(pushed_s), .free_s = std::max(0.0, time_s - length_s)};
  const double spin_change = lo.omega_radps - touchdown_.omega_radps;
  // The integral of the impulse's share over time, read off the vertical motion: vy = vy_TD + share·(vy_LO -
  // vy_TD).
  const double vy_td = touchdown_.vy_mps;
  const double share_s = (out.pulse.y_m - vy_td * pushed_s) / (lo.vy_mps - vy_td);
  out.displacement_m = out.pulse.x_m + lo.vx_mps * out.free_s;
  out.rotation_rad = touchdown_.omega_radps * time_s + spin_change * (share_s + out.free_s);
  return out;
}

LiftOff SinePath::plain_end() const {
  const Plain plain = plain_at(end_.dwell_s);
  LiftOff end = end_;
  end.displacement_m = plain.displacement_m;
  end.rotation_rad = plain.rotation_rad;
  return end;
}

Result<ContactPath> ContactPath::make(const Scene& scene, const ShotConditions& thrown, const Model& model,
                                      const ReducedContact* reduced) {
  if (!thrown.planar()) return in_space(scene, thrown, model);
  if (scene.bounce.contact == ContactLaw::grip) {
    const auto end = grip_lift_off(scene, thrown, model);
    return end ? by_sine(scene, thrown, *end) : tl::unexpected(end.error());
  }
  if (ode_is_asked(scene, model)) {
    if (model.has(Effect::contact_ode)) return by_ode(scene, thrown, model);
    const auto end = ode_lift_off(scene, thrown, model);
    return end ? by_sine(scene, thrown, *end) : tl::unexpected(end.error());
  }
  std::optional<ReducedContact> own;
  if (!reduced) {
    const auto calibrated = calibrate(scene, model);
    if (!calibrated) return tl::unexpected(calibrated.error());
    own = *calibrated;
    reduced = &*own;
  }
  const auto end = reduced_lift_off(scene, thrown, model, *reduced);
  return end ? by_sine(scene, thrown, *end) : tl::unexpected(end.error());
}

Result<ContactPath> ContactPath::by_ode(const Scene& scene, const ShotConditions& thrown,
                                        const Model& model) {
  const auto input = mechanics_input(scene, thrown, model);
  if (!input) return tl::unexpected(input.error());
  auto ode =
      impact::ContactCourse::make(scene.ball, thrown.touchdown, input->coefficients, contact_options(model));
  if (!ode) return refused(ode.error());
  const impact::ContactLiftOff& release = ode->lift_off();
  ContactPath path;
  path.release_ = {release.dwell_s, release.lift_off.vy_mps,
                   input->still_compressed_s * release.lift_off.vy_mps, input->coefficients.gravity_mps2,
                   input->coefficients.gravity_along_mps2};
  const auto end = risen(scene, thrown.touchdown, release, path.release_.depth_m, input->coefficients);
  if (!end) return tl::unexpected(end.error());
  path.end_ = *end;
  path.ode_ = std::move(*ode);
  return path;
}

Result<ContactPath> ContactPath::by_sine(const Scene& scene, const ShotConditions& thrown,
                                         const LiftOff& end) {
  auto sine = SinePath::make(scene, thrown.touchdown, end);
  if (!sine) return tl::unexpected(sine.error());
  const LiftOff plain = sine->plain_end();
  sine->displacement_correction_m_ = end.displacement_m - plain.displacement_m;
  sine->rotation_correction_rad_ = end.rotation_rad - plain.rotation_rad;
  ContactPath path;
  path.end_ = end;
  path.sine_ = *sine;
  return path;
}

std::optional<std::string> refusal_in_space(const Scene& scene, const Model& model) {
  const bool ode = scene.bounce.contact == ContactLaw::ode;
  const bool whole = !ode || (model.has(Effect::tangential_compliance) && model.has(Effect::contact_ode));
  if (whole && model.has(Effect::grip)) return std::nullopt;
  return std::string("a contact out of the plane needs grip") +
         (ode ? ", tangential_compliance and contact_ode" : "");
}

Result<ContactPath> ContactPath::in_space(const Scene& scene, const ShotConditions& thrown,
                                          const Model& model) {
  if (const auto refusal = refusal_in_space(scene, model)) return fail("model: " + *refusal);
  auto course = SpatialCourse::make(scene, thrown, model);
  if (!course) return tl::unexpected(course.error());
  ContactPath path;
  path.end_ = course->lift_off();
  path.spatial_ = std::make_shared<const SpatialCourse>(*std::move(course));
  return path;
}

ContactPath::State ContactPath::at(double time_s) const {
  return ode_ ? ode_at(time_s) : spatial_ ? spatial_->at(time_s) : sine_at(time_s);
}

ContactPath::State ContactPath::ode_at(double time_s) const {
  if (time_s <= release_.time_s) {
    const impact::ContactMotion s = ode_->at(time_s);
    return {
        s.x_m,         std::max(0.0, -s.y_m), s.velocity.vx_mps, s.velocity.vy_mps, s.velocity.omega_radps,
        s.rotation_rad};
  }
  const impact::Motion& lo = end_.rebound.lift_off;
  const double left_s = end_.dwell_s - time_s;
  const double free_s = time_s - release_.time_s;
  const double drop = release_.depth_m - free_s * (release_.vy_mps - 0.5 * release_.gravity_mps2 * free_s);
  return {end_.displacement_m - (lo.vx_mps - 0.5 * release_.along_mps2 * left_s) * left_s,
          std::max(0.0, drop),
          lo.vx_mps - release_.along_mps2 * left_s,
          release_.vy_mps - release_.gravity_mps2 * free_s,
          lo.omega_radps,
          end_.rotation_rad - lo.omega_radps * left_s};
}

ContactPath::State ContactPath::sine_at(double time_s) const {
  const SinePath& path = *sine_;
  const SinePath::Plain plain = path.plain_at(time_s);
  const impact::Motion& td = path.touchdown_;
  const impact::Motion& lo = end_.rebound.lift_off;
  // A correction that begins and ends without a change of velocity.
  const double part = time_s / end_.dwell_s;
  const double bend = part * part * (3.0 - 2.0 * part);
  const double bend_rate = 6.0 * part * (1.0 - part) / end_.dwell_s;
  return {plain.displacement_m + bend * path.displacement_correction_m_,
          std::max(0.0, -(plain.pulse.y_m + lo.vy_mps * plain.free_s)),
          plain.pulse.vx_mps + bend_rate * path.displacement_correction_m_,
          plain.pulse.vy_mps,
          td.omega_radps + (lo.omega_radps - td.omega_radps) * plain.pulse.impulse_fraction +
              bend_rate * path.rotation_correction_rad_,
          plain.rotation_rad + bend * path.rotation_correction_rad_};
}

}  // namespace strobe::sim
