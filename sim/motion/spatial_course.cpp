#include "sim/motion/spatial_course.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::sim {

namespace {

/// A twentieth of a radian each at 600 rad/s and 5 ms.
constexpr int kTurnSteps = 64;

impact::SpatialMotion motion_of(const ShotConditions& thrown) {
  const impact::Motion& td = thrown.touchdown;
  return {{td.vx_mps, td.vy_mps, thrown.vz_mps},
          {thrown.omega_x_radps, thrown.omega_y_radps, td.omega_radps}};
}

impact::Motion in_plane(const impact::SpatialMotion& m) {
  return {m.velocity_mps.x(), m.velocity_mps.y(), m.spin_radps.z()};
}

Turn turn_by(const Eigen::Vector3d& angle_rad) {
  const double size = angle_rad.norm();
  if (size == 0.0) return Turn::Identity();
  return Turn(Eigen::AngleAxisd(size, angle_rad / size));
}

/// Over `h` seconds from `from_s` with the spin `spin(time)`: Magnus' series to the fourth order (Blanes and
/// others, Phys. Rep. 470 (2009), 151).
template <typename Spin>
Turn turn_over(const Spin& spin, double from_s, double h) {
  const double aside = std::sqrt(3.0) / 6.0;
  const Eigen::Vector3d a = spin(from_s + (0.5 - aside) * h), b = spin(from_s + (0.5 + aside) * h);
  return turn_by(0.5 * h * (a + b) + 0.5 * aside * h * h * b.cross(a));
}

}  // namespace

Result<SpatialCourse> SpatialCourse::make(const Scene& scene, const ShotConditions& thrown,
                                          const Model& model) {
  return scene.bounce.contact == ContactLaw::ode ? by_mechanics(scene, thrown, model)
                                                 : by_sine(scene, thrown, model);
}

Result<SpatialCourse> SpatialCourse::by_mechanics(const Scene& scene, const ShotConditions& thrown,
                                                  const Model& model) {
  const auto input = mechanics_input(scene, thrown, model);
  if (!input) return tl::unexpected(input.error());
  auto mechanics = impact::SpatialContact::make(scene.ball, motion_of(thrown), input->coefficients,
                                                model.contact_tolerance());
  if (!mechanics) return fail(std::string(impact::message(mechanics.error())));
  SpatialCourse course;
  const impact::SpatialLiftOff& release = mechanics->lift_off();
  impact::ContactLiftOff flat;
  flat.lift_off = in_plane(release.motion);
  flat.regime = release.regime;
  flat.dwell_s = release.time_s;
  flat.dwell_distance_m = release.displacement_m.x();
  const double vy_mps = release.motion.velocity_mps.y();
  course.release_ = {release.time_s, vy_mps, input->still_compressed_s * vy_mps,
                     input->coefficients.gravity_mps2, input->coefficients.gravity_along_mps2};
  const auto end = risen(scene, thrown.touchdown, flat, course.release_.depth_m, input->coefficients);
  if (!end) return tl::unexpected(end.error());
  course.end_ = *end;
  course.mechanics_ = *std::move(mechanics);
  course.end_as(course.mechanics_at(end->dwell_s));
  return course;
}

Result<SpatialCourse> SpatialCourse::by_sine(const Scene& scene, const ShotConditions& thrown,
                                             const Model& model) {
  impact::Coefficients c = thrown.coefficients;
  if (!model.has(Effect::offset)) c.offset_m = 0.0;
  SpatialCourse course;
  course.touchdown_ = motion_of(thrown);
  const auto rebound = impact::grip(scene.ball, course.touchdown_, c);
  if (!rebound) return fail(std::string(impact::message(rebound.error())));
  course.change_ = {rebound->lift_off.velocity_mps - course.touchdown_.velocity_mps,
                    rebound->lift_off.spin_radps - course.touchdown_.spin_radps};
  LiftOff end;
  end.rebound.lift_off = in_plane(rebound->lift_off);
  end.rebound.regime = rebound->regime;
  end.rebound.slip_lo_mps = rebound->slip_lo_mps.x();
  end.rebound.impulse_ratio = -course.change_.velocity_mps.x() / course.change_.velocity_mps.y();
  end.rebound.offset_m = rebound->offset_m.x();
  end.dwell_s = thrown.dwell_s;
  const auto plain = SinePath::make(scene, thrown.touchdown, end);
  if (!plain) return tl::unexpected(plain.error());
  end.displacement_m = plain->plain_end().displacement_m;
  end.rotation_rad = plain->plain_end().rotation_rad;
  auto sine = ContactPath::by_sine(scene, thrown, end);
  if (!sine) return tl::unexpected(sine.error());
  course.sine_ = *std::move(sine);
  course.end_ = end;
  course.step_s_ = end.dwell_s / kTurnSteps;
  course.turned_.push_back(Turn::Identity());
  for (int i = 0; i < kTurnSteps; ++i) {
    const Turn step =
        turn_over([&](double t) { return course.sine_spin_at(t); }, i * course.step_s_, course.step_s_);
    course.turned_.push_back((step * course.turned_.back()).normalized());
  }
  course.end_as(course.sine_at(end.dwell_s));
  return course;
}

void SpatialCourse::end_as(const ContactPath::State& state) {
  end_.rotation_rad = 0.0;
  end_.aside_m = state.aside_m;
  end_.vz_mps = state.vz_mps;
  end_.omega_x_radps = state.omega_x_radps;
  end_.omega_y_radps = state.omega_y_radps;
  end_.turned = state.turned;
}

ContactPath::State SpatialCourse::at(double time_s) const {
  return mechanics_ ? mechanics_at(time_s) : sine_at(time_s);
}

ContactPath::State SpatialCourse::mechanics_at(double time_s) const {
  const impact::SpatialState s = mechanics_->at(std::min(time_s, release_.time_s));
  const double free_s = std::max(0.0, time_s - release_.time_s);
  const Eigen::Vector3d& v = s.motion.velocity_mps;
  const Eigen::Vector3d& spin = s.motion.spin_radps;
  const double drop_m =
      free_s > 0.0 ? release_.depth_m - free_s * (release_.vy_mps - 0.5 * release_.gravity_mps2 * free_s)
                   : -s.displacement_m.y();
  return {.displacement_m = s.displacement_m.x() + (v.x() + 0.5 * release_.along_mps2 * free_s) * free_s,
          .drop_m = std::max(0.0, drop_m),
          .vx_mps = v.x() + release_.along_mps2 * free_s,
          .vy_mps = v.y() - release_.gravity_mps2 * free_s,
          .omega_radps = spin.z(),
          .aside_m = s.displacement_m.z() + v.z() * free_s,
          .vz_mps = v.z(),
          .omega_x_radps = spin.x(),
          .omega_y_radps = spin.y(),
          .turned = Turn(turn_by(spin * free_s) * Turn(s.rotation))};
}

Eigen::Vector3d SpatialCourse::sine_spin_at(double time_s) const {
  const double gone = (sine_->at(time_s).vy_mps - touchdown_.velocity_mps.y()) / change_.velocity_mps.y();
  return touchdown_.spin_radps + gone * change_.spin_radps;
}

ContactPath::State SpatialCourse::sine_at(double time_s) const {
  ContactPath::State s = sine_->at(time_s);
  // The part of the impulse that has acted, and its integral over time, from the vertical motion.
  const double vy_mps = touchdown_.velocity_mps.y(), change_mps = change_.velocity_mps.y();
  const double gone = (s.vy_mps - vy_mps) / change_mps;
  const double gone_s = (-s.drop_m - vy_mps * time_s) / change_mps;
  s.aside_m = touchdown_.velocity_mps.z() * time_s + gone_s * change_.velocity_mps.z();
  s.vz_mps = touchdown_.velocity_mps.z() + gone * change_.velocity_mps.z();
  s.omega_x_radps = touchdown_.spin_radps.x() + gone * change_.spin_radps.x();
  s.omega_y_radps = touchdown_.spin_radps.y() + gone * change_.spin_radps.y();
  s.rotation_rad = 0.0;
  const auto step = static_cast<std::size_t>(std::clamp(time_s / step_s_, 0.0, 1.0 * kTurnSteps));
  const double from_s = static_cast<double>(step) * step_s_;
  s.turned = turn_over([this](double t) { return sine_spin_at(t); }, from_s, time_s - from_s) * turned_[step];
  return s;
}

}  // namespace strobe::sim
