#include "sim/motion/ball_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace strobe::sim {

namespace {

void add(BallState& sum, const BallState& s, double weight) {
  sum.x_m += weight * s.x_m;
  sum.y_m += weight * s.y_m;
  sum.equator_rad += weight * s.equator_rad;
  sum.top_drop_m += weight * s.top_drop_m;
  sum.z_m += weight * s.z_m;
}

/// Along with what else is that of the middle.
void take_speeds(BallState& mean, const BallState& middle) {
  mean.vx_mps = middle.vx_mps;
  mean.vy_mps = middle.vy_mps;
  mean.omega_radps = middle.omega_radps;
  mean.vz_mps = middle.vz_mps;
  mean.omega_x_radps = middle.omega_x_radps;
  mean.omega_y_radps = middle.omega_y_radps;
  mean.turned = middle.turned;
}

}  // namespace

BallPath::BallPath(const Scene& scene, const ShotConditions& thrown, const Model& model, ContactPath contact)
    : conditions_(thrown),
      contact_(std::move(contact)),
      radius_m_(scene.ball.radius_m()),
      top_drop_ratio_(scene.bounce.top_drop_ratio),
      approach_(flight_from(scene, model, false)),
      departure_(flight_from(scene, model, true)) {}

Flight BallPath::flight_from(const Scene& scene, const Model& model, bool rebounding) const {
  const LiftOff& end = contact_.lift_off();
  const impact::Motion& from = rebounding ? end.rebound.lift_off : conditions_.touchdown;
  FlightState start{rebounding ? end.displacement_m : 0.0, radius_m_, from.vx_mps, from.vy_mps};
  if (planar()) return Flight(scene, start, from.omega_radps, model);
  start.z_m = rebounding ? end.aside_m : 0.0;
  start.vz_mps = rebounding ? end.vz_mps : conditions_.vz_mps;
  const Eigen::Vector3d spin(rebounding ? end.omega_x_radps : conditions_.omega_x_radps,
                             rebounding ? end.omega_y_radps : conditions_.omega_y_radps, from.omega_radps);
  return Flight(scene, start, spin, model);
}

Result<BallPath> BallPath::make(const Scene& scene, const ShotConditions& thrown, const Model& model,
                                const ReducedContact* reduced) {
  auto contact = ContactPath::make(scene, thrown, model, reduced);
  if (!contact) return tl::unexpected(contact.error());
  BallPath path(scene, thrown, model, std::move(*contact));
  path.bounce_again(scene, model, reduced, scene.bounce.count - 1);
  return path;
}

void BallPath::bounce_again(const Scene& scene, const Model& model, const ReducedContact* reduced,
                            int times) {
  if (times <= 0) return;
  const auto flight_s = departure_.time_back_down_s();
  if (!flight_s) return;
  const BallState down = at(dwell_s() + *flight_s);
  ShotConditions again =
      conditions_of_next_bounce(scene, conditions_, {down.vx_mps, down.vy_mps, down.omega_radps});
  again.vz_mps = down.vz_mps;
  again.omega_x_radps = down.omega_x_radps;
  again.omega_y_radps = down.omega_y_radps;
  // It lies on the surface from there on if its weight holds it.
  auto contact = ContactPath::make(scene, again, model, reduced);
  if (!contact) return;
  BallPath next(scene, again, model, std::move(*contact));
  next.conditions_.equator_rad = down.equator_rad;
  next.bounce_again(scene, model, reduced, times - 1);
  next_at_s_ = dwell_s() + *flight_s;
  next_x_m_ = down.x_m;
  next_z_m_ = down.z_m;
  next_turned_ = down.turned;
  next_ = std::make_shared<const BallPath>(std::move(next));
}

BallState BallPath::contact_at(double time_s) const {
  const ContactPath::State c = contact_.at(time_s);
  return {.x_m = c.displacement_m,
          .y_m = radius_m_ - c.drop_m,
          .vx_mps = c.vx_mps,
          .vy_mps = c.vy_mps,
          .omega_radps = c.omega_radps,
          .equator_rad = conditions_.equator_rad + c.rotation_rad,
          .top_drop_m = top_drop_ratio_ * c.drop_m,
          .z_m = c.aside_m,
          .vz_mps = c.vz_mps,
          .omega_x_radps = c.omega_x_radps,
          .omega_y_radps = c.omega_y_radps,
          .turned = c.turned};
}

BallState BallPath::at(double time_s) const {
  if (bounced_again(time_s)) {
    BallState s = next_->at(time_s - next_at_s_);
    s.x_m += next_x_m_;
    if (planar()) return s;
    s.z_m += next_z_m_;
    s.turned = s.turned * next_turned_;
    return s;
  }
  const LiftOff& end = contact_.lift_off();
  if (time_s > 0.0 && time_s < end.dwell_s) return contact_at(time_s);
  const bool rebounding = time_s > 0.0;
  return in_flight(rebounding ? departure_.at(time_s - end.dwell_s) : approach_.at(time_s), rebounding);
}

BallState BallPath::in_flight(const FlightState& s, bool rebounding) const {
  if (!planar()) {
    const Eigen::Vector3d& axis = (rebounding ? departure_ : approach_).axis();
    const Turn turned(Eigen::AngleAxisd(s.rotation_rad, axis));
    return {.x_m = s.x_m,
            .y_m = s.y_m,
            .vx_mps = s.vx_mps,
            .vy_mps = s.vy_mps,
            .omega_radps = s.omega_radps * axis.z(),
            .equator_rad = conditions_.equator_rad,
            .z_m = s.z_m,
            .vz_mps = s.vz_mps,
            .omega_x_radps = s.omega_radps * axis.x(),
            .omega_y_radps = s.omega_radps * axis.y(),
            .turned = rebounding ? Turn(turned * contact_.lift_off().turned) : turned};
  }
  const double turned_rad = rebounding ? contact_.lift_off().rotation_rad : 0.0;
  return {.x_m = s.x_m,
          .y_m = s.y_m,
          .vx_mps = s.vx_mps,
          .vy_mps = s.vy_mps,
          .omega_radps = s.omega_radps,
          .equator_rad = conditions_.equator_rad + turned_rad + s.rotation_rad};
}

BallPath::Place BallPath::roughly_at(double time_s) const {
  if (bounced_again(time_s)) {
    const Place next = next_->roughly_at(time_s - next_at_s_);
    return {next.x_m + next_x_m_, next.y_m};
  }
  if (time_s < dwell_s()) {
    const BallState s = at(time_s);
    return {s.x_m, s.y_m};
  }
  const FlightState s = departure_.roughly_at(time_s - dwell_s());
  return {s.x_m, s.y_m};
}

std::array<BallState, 4> BallPath::at(const Flight::Instants& time_s) const {
  const auto [first, last] = std::ranges::minmax(time_s);
  const double dwell = dwell_s();
  const bool rebounding = first > 0.0;
  const bool flies = last <= 0.0 || (rebounding && first >= dwell && !bounced_again(last));
  if (!flies) return {at(time_s[0]), at(time_s[1]), at(time_s[2]), at(time_s[3])};
  Flight::Instants since_s = time_s;
  if (rebounding)
    for (double& each_s : since_s) each_s -= dwell;
  const auto flight = (rebounding ? departure_ : approach_).at(since_s);
  std::array<BallState, 4> out;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = in_flight(flight[i], rebounding);
  return out;
}

BallPath::Lit BallPath::lit(double from_s, double duration_s) const {
  if (duration_s == 0.0) {
    const BallState s = at(from_s);
    return {s, s};
  }
  const double half_s = 0.5 * duration_s;
  const double aside_s = half_s * std::sqrt(0.6);
  const double middle_s = from_s + half_s;
  const auto [begin, before, middle, after] =
      at(Flight::Instants{from_s, middle_s - aside_s, middle_s, middle_s + aside_s});
  BallState mean;
  add(mean, before, 5.0 / 18.0);
  add(mean, middle, 8.0 / 18.0);
  add(mean, after, 5.0 / 18.0);
  take_speeds(mean, middle);
  return {begin, mean};
}

std::optional<double> BallPath::time_at_distance_s(double distance_m) const {
  return approach_.time_back_at_x_s(-distance_m);
}

}  // namespace strobe::sim
