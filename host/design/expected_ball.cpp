#include "host/design/expected_ball.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/units/angles.hpp"

namespace strobe::host {
namespace {

constexpr std::size_t kDrawnNumbers = 9;
constexpr double kShortestDwell_s = 1e-4, kLongestDwell_s = 0.05;
constexpr double kSteepest_rad = -0.5 * std::numbers::pi, kFlattest_rad = -std::numbers::pi / 180.0;
constexpr double kContactTolerance = 1e-3;  // far less than balls differ
constexpr double kSlowest_mps = 0.5, kFastest_mps = 100.0;

double normal_quantile(double probability) {
  return std::numbers::sqrt2 * boost::math::erf_inv(2.0 * probability - 1.0);
}

constexpr std::array kDeviates{&BallDraw::speed, &BallDraw::angle, &BallDraw::spin,    &BallDraw::e,
                               &BallDraw::mu,    &BallDraw::dwell, &BallDraw::arrival, &BallDraw::spot};
static_assert(kDeviates.size() + 1 == kDrawnNumbers);

/// Few draws lack the tails: mean 0 and standard deviation 1 by moment matching.
void standardize(std::vector<BallDraw>& draws, double BallDraw::*number) {
  const auto n = static_cast<double>(draws.size());
  double sum = 0.0, squares = 0.0;
  for (const BallDraw& d : draws) sum += d.*number;
  for (const BallDraw& d : draws) squares += (d.*number - sum / n) * (d.*number - sum / n);
  if (!(squares > 0.0)) return;
  for (BallDraw& d : draws) d.*number = (d.*number - sum / n) / std::sqrt(squares / n);
}

double drawn(const Spread& spread, double deviate, double low, double high) {
  return std::clamp(spread.mean + deviate * spread.sd, low, high);
}

flight::Flight flight_from(const Eigen::Vector2d& place_m, const impact::Motion& motion,
                           const flight::Aerodynamics& air, const Eigen::Vector2d& gravity_mps2) {
  const Eigen::Vector2d velocity(motion.vx_mps, motion.vy_mps);
  return {place_m, velocity, flight::forcing(air, gravity_mps2, velocity, motion.omega_radps)};
}

}  // namespace

std::optional<std::string> problem_of(const ExpectedBall& ball) {
  const auto outside = [](double value, double low, double high) { return !(value >= low && value <= high); };
  for (const Spread* spread :
       {&ball.speed_mps, &ball.angle_rad, &ball.spin_radps, &ball.e, &ball.mu, &ball.dwell_s})
    if (!(spread->sd >= 0.0 && std::isfinite(spread->sd))) return "a spread is below 0";
  if (outside(ball.speed_mps.mean, kSlowest_mps, kFastest_mps))
    return fmt::format("speed: must be {} to {} m/s", kSlowest_mps, kFastest_mps);
  if (outside(ball.angle_rad.mean, kSteepest_rad, kFlattest_rad)) return "angle: must be 1 to 90 degrees";
  if (outside(ball.spin_radps.mean, -1e4, 1e4)) return "spin: must be within 10,000 rad/s";
  if (outside(ball.e.mean, 0.01, 1.0)) return "e: must be 0.01 to 1";
  if (outside(ball.mu.mean, 0.0, 10.0)) return "mu: must be 0 to 10";
  if (outside(ball.dwell_s.mean, kShortestDwell_s, kLongestDwell_s))
    return "dwell time: must be 0.1 to 50 ms";
  return std::nullopt;
}

std::vector<BallDraw> ball_draws(std::size_t count) {
  boost::random::sobol sequence(kDrawnNumbers);
  const auto scale = static_cast<double>(boost::random::sobol::max()) + 1.0;
  const auto next = [&] { return (static_cast<double>(sequence()) + 0.5) / scale; };
  sequence.discard(kDrawnNumbers);  // the origin's
  std::vector<BallDraw> draws(count);
  for (BallDraw& d : draws) {
    for (double BallDraw::*number : kDeviates) d.*number = normal_quantile(next());
    d.equator_rad = kPi * next();
  }
  for (double BallDraw::*number : kDeviates) standardize(draws, number);
  return draws;
}

Result<BallCourse> BallCourse::make(const ExpectedBall& expected, const BallDraw& draw,
                                    const Eigen::Vector2d& gravity_mps2) {
  const double speed_mps = drawn(expected.speed_mps, draw.speed, kSlowest_mps, kFastest_mps);
  const double angle_rad = drawn(expected.angle_rad, draw.angle, kSteepest_rad, kFlattest_rad);
  BallCourse course;
  course.touchdown_ = {speed_mps * std::cos(angle_rad), speed_mps * std::sin(angle_rad),
                       expected.spin_radps.mean + draw.spin * expected.spin_radps.sd};
  impact::ContactCoefficients contact;
  contact.e = drawn(expected.e, draw.e, 0.01, 1.0);
  contact.mu = drawn(expected.mu, draw.mu, 0.0, 10.0);
  contact.dwell_s = drawn(expected.dwell_s, draw.dwell, kShortestDwell_s, kLongestDwell_s);
  const auto bounce =
      impact::lift_off(expected.ball, course.touchdown_, contact, {.tolerance = kContactTolerance});
  if (!bounce) return fail(std::string(impact::message(bounce.error())));
  course.lift_off_ = bounce->lift_off;
  course.dwell_s_ = contact.dwell_s;
  course.dwell_distance_m_ = 0.5 * (course.touchdown_.vx_mps + course.lift_off_.vx_mps) * course.dwell_s_;
  course.radius_m_ = expected.ball.radius_m();
  const flight::Aerodynamics air =
      flight::aerodynamics(expected.ball, expected.air_density_kgpm3, {}, expected.air_law());
  course.approach_ = flight_from({0.0, course.radius_m_}, course.touchdown_, air, gravity_mps2);
  course.departure_ =
      flight_from({course.dwell_distance_m_, course.radius_m_}, course.lift_off_, air, gravity_mps2);
  return course;
}

BallCourse::Place BallCourse::at(double time_s) const {
  if (time_s > 0.0 && time_s < dwell_s_) {
    const double share = time_s / dwell_s_;
    return {.centre_m = {share * dwell_distance_m_, radius_m_},
            .speed_mps = std::abs((1.0 - share) * touchdown_.vx_mps + share * lift_off_.vx_mps),
            .equator_rad = time_s * touchdown_.omega_radps,
            .in_contact = true};
  }
  const bool before = time_s <= 0.0;
  const flight::Flight& flight = before ? approach_ : departure_;
  const double since_s = before ? time_s : time_s - dwell_s_;
  const double turned_rad = before ? since_s * touchdown_.omega_radps
                                   : dwell_s_ * touchdown_.omega_radps + since_s * lift_off_.omega_radps;
  const Eigen::Vector2d place_m = flight.position_at(since_s);
  const Eigen::Vector2d velocity_mps = flight.velocity_at(since_s);
  return {.centre_m = place_m,
          .speed_mps = velocity_mps.norm(),
          .equator_rad = turned_rad,
          .beyond = place_m.y() < radius_m_ || (before && velocity_mps.y() > 0.0)};
}

}  // namespace strobe::host
