#include "common/reduction/surface_crossing.hpp"

#include <algorithm>
#include <cmath>

#include "common/reduction/spin_line.hpp"

namespace strobe::reduction {
namespace {

/// Follows the errors of the air: what they bend the fit straightens as far as it can.
Number unknown(const ShotFit& fit, std::size_t index) {
  Number u = Number::variable(fit.joint.unknowns[index], index);
  for (std::size_t p = 0; p < kAirErrorCount; ++p) u.grad[kAir + p] = fit.air_fit.response[p][index];
  return u;
}

/// Flight of one leg about its origin of time in the surface's axes; the height is less a radius.
struct Path {
  Number x_m, height_m, vx_mps, vy_mps;
  const flight::Forcing& forcing;

  flight::Flight values() const {
    return {{x_m.value, height_m.value}, {vx_mps.value, vy_mps.value}, forcing};
  }
};

Path path(const ShotFit& fit, std::size_t leg) {
  const std::size_t k = kLegStart[leg];
  const Number tilt = unknown(fit, kTilt);
  const Number cos = chain(tilt, std::cos(tilt.value), -std::sin(tilt.value));
  const Number sin = chain(tilt, std::sin(tilt.value), std::cos(tilt.value));
  const Number scale = unknown(fit, kScale);
  const Number per_second = scale * fit.joint.legs[leg].span_s;
  const Number px = unknown(fit, k);
  const Number py = unknown(fit, k + 1);
  const Number ux = unknown(fit, k + 2);
  const Number uy = unknown(fit, k + 3);
  return {(cos * px + sin * py) / scale, (cos * py - sin * px - unknown(fit, kHeight)) / scale - radius(fit),
          (cos * ux + sin * uy) / per_second, (cos * uy - sin * ux) / per_second, fit.joint.forcing[leg]};
}

/// Adds the derivatives of a force that depends on the velocity.
void add_derivatives(const Number& vx, const Number& vy, double by_vx, double by_vy, Number& into) {
  for (std::size_t i = 0; i < into.grad.size(); ++i) into.grad[i] += by_vx * vx.grad[i] + by_vy * vy.grad[i];
}

/// From the leg's origin.
std::optional<double> meets_surface_s(const flight::Flight& flight, double edge_s, bool falls) {
  const double vy_edge = flight.velocity_at(edge_s).y();
  if (falls ? !(vy_edge < 0.0) : !(vy_edge > 0.0)) return std::nullopt;
  const auto at = falls ? flight.time_falling_through_s(0.0) : flight.time_rising_through_s(0.0);
  if (!at) return std::nullopt;
  const double vy = flight.velocity_at(*at).y();
  return (falls ? vy < 0.0 : vy > 0.0) ? at : std::nullopt;
}

SurfaceCrossing in_photograph(const ShotFit& fit, const SurfaceCrossing& level) {
  const Number tilt = unknown(fit, kTilt);
  const Number cos = chain(tilt, std::cos(tilt.value), -std::sin(tilt.value));
  const Number sin = chain(tilt, std::sin(tilt.value), std::cos(tilt.value));
  return {level.time_s, level.x_m, cos * level.vx_mps - sin * level.vy_mps,
          sin * level.vx_mps + cos * level.vy_mps};
}

/// The two whitened measurements of an image's centre, and how they change with its time.
struct Moved {
  ImageRows rows;
  Eigen::Vector2d by_time;
};

Moved moved_by_time(const ShotFit& fit, const geometry::Rotation2d& tilt, const Observation& o) {
  const JointFit& joint = fit.joint;
  const std::size_t leg = leg_index(*o.leg);
  Moved moved{image_rows(fit.observations, joint, tilt, o), Eigen::Vector2d::Zero()};
  const double t = moved.rows.time_s;
  const flight::Forcing& forcing = joint.forcing[leg];
  const Eigen::Vector2d gained = t * (forcing.acceleration_mps2 + 0.5 * t * forcing.jerk_mps3);
  const double* z = &joint.unknowns[kLegStart[leg]];
  const Eigen::Vector2d velocity =
      Eigen::Vector2d(z[2], z[3]) / joint.legs[leg].span_s + joint.unknowns[kScale] * (tilt * gained);
  moved.by_time[0] = -moved.rows.white.first(velocity.x());
  moved.by_time[1] = -moved.rows.white.second(velocity.x(), velocity.y());
  return moved;
}

/// The air's errors follow what the paths do not take up of the images.
void add_air(const ShotFit& fit, const geometry::Rotation2d& tilt, std::size_t leg, const Moved& moved,
             const JointVector& right, Response& response) {
  const AirFit& air = fit.air_fit;
  std::array<double, kAirErrorCount> left{};
  for (std::size_t p = 0; p < kAirErrorCount; ++p) {
    const Eigen::Vector2d pull = fit.joint.unknowns[kScale] * (tilt * air.acceleration_mps2[p][leg]);
    const Eigen::Vector2d bent = moved.rows.moved_by(pull);
    left[p] = bent.x() * moved.by_time[0] + bent.y() * moved.by_time[1] + dot(air.response[p], right);
  }
  for (std::size_t p = 0; p < kAirErrorCount; ++p) {
    for (std::size_t q = 0; q < kAirErrorCount; ++q)
      response[kAir + p] += (air.by_noise[p][q] + air.by_prior[p][q]) * left[q];
  }
}

void add_spin(const ShotFit& fit, std::size_t leg, std::vector<Response>& all) {
  const auto& spin = fit.spin[leg];
  if (!spin) return;
  SpinLine line;
  for (const EquatorReading& r : fit.equators[leg]) line.add(r.time_s, 0.0, weight(r, spin->omega_radps));
  for (const EquatorReading& r : fit.equators[leg]) {
    const double lever = weight(r, spin->omega_radps) * (r.time_s - line.mean_x()) / line.moment();
    all[r.index][kSpin[leg]] = -lever * spin->omega_radps;
  }
}

}  // namespace

Number radius(const ShotFit& fit) {
  return Number::variable(fit.observations.ball_diameter_m, kDiameter) * 0.5;
}

flight::Flight flight_of(const ShotFit& fit, std::size_t leg) { return path(fit, leg).values(); }

/// The instant is found in plain numbers; one Newton step in dual ones from there gives its
/// derivatives.
std::optional<SurfaceCrossing> crossing(const ShotFit& fit, std::size_t leg) {
  const LegTime& times = fit.joint.legs[leg];
  if (!times.fitted || fit.joint.degenerate()) return std::nullopt;
  const Path p = path(fit, leg);
  const flight::Flight values = p.values();
  const bool surface = fit.observations.has_surface();
  const double edge = (leg == 0 && surface ? times.last_s : times.first_s) - times.origin_s;
  const auto at = surface ? meets_surface_s(values, edge, leg == 0) : std::optional(edge);
  if (!at) return std::nullopt;
  const double t = *at;
  const Eigen::Vector2d there = values.velocity_at(t);
  Number ax = p.forcing.acceleration_mps2.x();
  Number ay = p.forcing.acceleration_mps2.y();
  const Eigen::Matrix2d& by_v = p.forcing.by_velocity_per_s;
  add_derivatives(p.vx_mps, p.vy_mps, by_v(0, 0), by_v(0, 1), ax);
  add_derivatives(p.vx_mps, p.vy_mps, by_v(1, 0), by_v(1, 1), ay);
  for (std::size_t i = 0; i < kAirErrorCount; ++i) {
    if (!(fit.air_fit.prior[i].sd > 0.0)) continue;
    ax.grad[kAir + i] += fit.air_fit.acceleration_mps2[i][leg].x();
    ay.grad[kAir + i] += fit.air_fit.acceleration_mps2[i][leg].y();
  }
  const Eigen::Vector2d& j = p.forcing.jerk_mps3;
  Number time = t;
  if (surface) {
    time = -1.0 / there.y() * (p.height_m + p.vy_mps * t + ay * (0.5 * t * t));
    time.grad[kInstant[leg]] = 1.0;
  }
  time.value = t;
  // By the chain rule through the crossing's time.
  Number x = p.x_m + p.vx_mps * t + ax * (0.5 * t * t);
  Number vx = p.vx_mps + ax * t;
  Number vy = p.vy_mps + ay * t;
  x.value += j.x() * t * t * t / 6.0;
  vx.value = there.x();
  vy.value = there.y();
  for (std::size_t i = 0; i < time.grad.size(); ++i) {
    x.grad[i] += there.x() * time.grad[i];
    vx.grad[i] += (ax.value + j.x() * t) * time.grad[i];
    vy.grad[i] += (ay.value + j.y() * t) * time.grad[i];
  }
  time.value += times.origin_s;
  const SurfaceCrossing level{time, x, vx, vy};
  return surface ? level : in_photograph(fit, level);
}

std::vector<Response> time_response(const ShotFit& fit) {
  std::vector<Response> all(fit.observations.images.size(), Response{});
  const geometry::Rotation2d tilt = tilt_of(fit.joint);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Observation& o = fit.observations.images[i];
    if (!o.use_centre || !fit.joint.legs[leg_index(*o.leg)].fitted) continue;
    const std::size_t leg = leg_index(*o.leg);
    const Moved moved = moved_by_time(fit, tilt, o);
    JointVector right{};
    moved.rows.add_gradient(leg, moved.by_time, right);
    const JointVector unknowns = fit.joint.factor.unknowns(fit.joint.factor.whitened(right));
    std::copy(unknowns.begin(), unknowns.end(), all[i].begin());
    add_air(fit, tilt, leg, moved, right, all[i]);
  }
  for (std::size_t leg = 0; leg < 2; ++leg) add_spin(fit, leg, all);
  return all;
}

}  // namespace strobe::reduction
