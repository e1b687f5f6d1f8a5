#include "tests/common/reduction/simulated_shot.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>

namespace strobe::test {
namespace {

using namespace reduction;

constexpr double kPi = std::numbers::pi;

/// The fifteen unknowns. Positions are those at the moments of the leg's reference time (0 and dwell).
struct Unknowns {
  double tilt, height_px, px_per_m;
  double in[6];  // x, y [m], vx, vy, equator [rad], omega
  double out[6];
};
constexpr int kUnknowns = 15;

Unknowns unknowns_of(const Bounce& b, const Setup& s) {
  return {s.roll_rad,
          s.origin_y_px,
          s.px_per_m,
          {0.0, b.diameter_m / 2, b.vx_td, b.vy_td, 0.7, b.omega_td},
          {b.dwell_x_m, b.diameter_m / 2, b.vx_lo, b.vy_lo, -0.4, b.omega_lo}};
}

double& entry(Unknowns& u, int i) {
  if (i == 0) return u.tilt;
  if (i == 1) return u.height_px;
  if (i == 2) return u.px_per_m;
  return i < 9 ? u.in[i - 3] : u.out[i - 9];
}

struct Point {
  double x, y;
};

/// The leg's flight, integrated by the classical Runge-Kutta method. Velocities change at rates below q·|v|,
/// 0.6 per second at 30 m/s: a step of 6 ms errs by less than v·(6e-3·0.6)^5/120, 2e-13 m/s, and as much of a
/// metre.
class Flight {
 public:
  Flight(const double* leg, double radius_m, const Setup& s)
      : start_{leg[0], leg[1], leg[2], leg[3]},
        rim_(radius_m * leg[5]),
        gravity_{-s.gravity_mps2 * std::sin(s.incline_rad), -s.gravity_mps2 * std::cos(s.incline_rad)} {
    const double q = s.air.density_kgpm3 * kPi * radius_m * radius_m / (2 * s.air.mass_kg);
    drag_ = q * s.air.drag_coefficient;
    lift_ = s.air.lift ? q : 0.0;
    spin_ = leg[5];
    fading_ = s.air.spin_decay_per_m * s.air.density_kgpm3 / 1.204 * std::hypot(leg[2], leg[3]);
  }

  /// By how much the ball has turned. The speed's own change in a leg, 1 % at most, changes the decay by 1 %
  /// of itself.
  double turned(double t) const {
    return fading_ == 0.0 ? spin_ * t : -spin_ / fading_ * std::expm1(-fading_ * t);
  }

  /// x, y, vx, vy
  using State = std::array<double, 4>;

  State at(double t) const {
    const int steps = static_cast<int>(std::ceil(std::abs(t) / 6e-3));
    State s = start_;
    for (int i = 0; i < steps; ++i) s = step(s, t / steps);
    return s;
  }

 private:
  State slope(const State& s) const {
    const double v = std::sqrt(s[2] * s[2] + s[3] * s[3]);
    const double lift = lift_ * v * rim_ / (2 * std::abs(rim_) + v);
    return {s[2], s[3], gravity_.x - drag_ * v * s[2] - lift * s[3],
            gravity_.y - drag_ * v * s[3] + lift * s[2]};
  }
  static State moved(State s, const State& by, double h) {
    for (std::size_t i = 0; i < s.size(); ++i) s[i] += h * by[i];
    return s;
  }
  State step(const State& s, double h) const {
    const State a = slope(s);
    const State b = slope(moved(s, a, h / 2));
    const State c = slope(moved(s, b, h / 2));
    const State d = slope(moved(s, c, h));
    return moved(moved(moved(moved(s, a, h / 6), b, h / 3), c, h / 3), d, h / 6);
  }

  State start_;
  double spin_ = 0.0, fading_ = 0.0, rim_;
  Point gravity_;
  double drag_ = 0.0, lift_ = 0.0;
};

Point place(const Flight::State& s) { return {s[0], s[1]}; }

PointPx project(Point p, const Unknowns& u, const Setup& s) {
  const double x = (std::cos(u.tilt) * p.x - std::sin(u.tilt) * p.y) * u.px_per_m;
  const double y = (std::sin(u.tilt) * p.x + std::cos(u.tilt) * p.y) * u.px_per_m;
  return {s.origin_x_px + x, u.height_px + y};
}

std::vector<double> incoming_times(const Setup& s) {
  std::vector<double> times;
  for (int i = s.incoming - 1; i >= 0; --i) times.push_back(-(s.phase + i) * s.period_s);
  times.back() += s.late_before_td_s;
  return times;
}

std::vector<double> contact_times(const Bounce& b, const Setup& s) {
  std::vector<double> times;
  for (double t = (1.0 - s.phase) * s.period_s; t < b.dwell_s; t += s.period_s) times.push_back(t);
  return times;
}

std::vector<double> rebound_times(const Bounce& b, const Setup& s) {
  std::vector<double> times;
  const double first = (1.0 - s.phase + static_cast<double>(contact_times(b, s).size())) * s.period_s;
  for (int i = 0; i < s.rebound; ++i) times.push_back(first + i * s.period_s);
  return times;
}

}  // namespace

std::uint64_t seed_or(std::uint64_t own) {
  const char* text = std::getenv("STROBE_SEED");
  return text ? std::strtoull(text, nullptr, 10) : own;
}

std::vector<Bounce> thesis_bounces() {
  std::ifstream file(STROBE_THESIS_FOLDER "/tables_02_to_10.csv");
  std::string line;
  std::getline(file, line);
  std::vector<Bounce> bounces;
  while (std::getline(file, line)) {
    std::vector<std::string> cells;
    std::stringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    const auto number = [&](std::size_t i) { return std::stod(cells.at(i)); };
    Bounce b;
    b.label = cells.at(0) + "_" + cells.at(1);
    b.vx_td = number(7), b.vy_td = number(9), b.omega_td = number(13);
    b.vx_lo = number(17), b.vy_lo = number(19), b.omega_lo = number(23);
    b.dwell_x_m = number(29) * 1e-2, b.dwell_s = number(31) * 1e-3;
    if (b.label == "zero_68") b.dwell_x_m = 1.61e-2;  // printed as 0.16 by mistake
    bounces.push_back(b);
  }
  return bounces;
}

Frame photograph(const Bounce& b, const Setup& s, Random& random) {
  const auto normal = [&](double sd) {
    return std::normal_distribution<double>(0.0, 1.0)(random) * sd * s.noise_factor;
  };
  const Unknowns u = unknowns_of(b, s);
  const Flight in(u.in, b.diameter_m / 2, s);
  const Flight out(u.out, b.diameter_m / 2, s);
  Frame frame;
  frame.shot_id = 1;
  frame.ball_diameter_m = b.diameter_m;
  frame.fastest_spin_radps = s.fastest_spin_radps;
  frame.surface_angle_deg = s.incline_rad * 180 / kPi * (s.mirror ? -1 : 1);
  for (const double x : s.surface_x_m) {
    PointPx p = project({x, 0.0}, u, s);
    p.x += normal(s.surface_sd_m * s.px_per_m);
    p.y += normal(s.surface_sd_m * s.px_per_m);
    frame.surface_px.push_back(p);
  }
  const auto add = [&](double time, Leg leg, Point at, double angle) {
    BallImage image;
    image.time_s = s.time_origin_s + time;
    if (s.labels) image.leg = leg;
    image.centre_px = project(at, u, s);
    image.centre_px.x += normal(s.centre_sd_m * s.px_per_m);
    image.centre_px.y += normal(s.centre_sd_m * s.px_per_m);
    image.diameter_px = b.diameter_m * s.px_per_m + normal(s.diameter_sd_m * s.px_per_m);
    const double seen = angle + s.roll_rad + normal(s.equator_sd_rad);
    image.equator_rad = seen - kPi * std::floor(seen / kPi);
    frame.images.push_back(image);
  };
  const auto jitter = [&] { return s.flash_jitter_s * std::normal_distribution<double>(0.0, 1.0)(random); };
  const double start_angle = std::uniform_real_distribution<double>(0.0, kPi)(random);
  for (double t : incoming_times(s)) {
    t += jitter();
    add(t, Leg::incoming, place(in.at(t)), start_angle + in.turned(t));
  }
  for (const double t : contact_times(b, s)) {
    // Half a sine of vertical squash: only that it is low matters here.
    const double drop = -b.vy_td * b.dwell_s / kPi * std::sin(kPi * t / b.dwell_s);
    add(t, Leg::contact, {b.dwell_x_m * t / b.dwell_s, b.diameter_m / 2 - drop}, start_angle);
  }
  for (double t : rebound_times(b, s)) {
    t += jitter();
    add(t, Leg::rebound, place(out.at(t - b.dwell_s)), start_angle + 1.0 + out.turned(t - b.dwell_s));
  }
  if (s.state_noise) {
    frame.centre_sd_px = s.centre_sd_m * s.px_per_m;
    frame.diameter_sd_px = s.diameter_sd_m * s.px_per_m;
    frame.equator_sd_rad = s.equator_sd_rad;
    if (s.surface_sd_m != s.centre_sd_m) frame.surface_sd_px = s.surface_sd_m * s.px_per_m;
  }
  if (s.mirror) {
    for (PointPx& p : frame.surface_px) p.x = -p.x;
    for (BallImage& image : frame.images) {
      image.centre_px.x = -image.centre_px.x;
      if (image.equator_rad) image.equator_rad = -*image.equator_rad;
    }
  }
  return frame;
}

Frame flight_alone(const Bounce& bounce, Setup setup, Random& random) {
  Bounce flight = bounce;
  flight.dwell_s = 0.0;  // no image in contact
  setup.rebound = 0;
  setup.surface_x_m.clear();
  return photograph(flight, setup, random);
}

Quantities launch_truth(const Bounce& b, const Setup& s) {
  const Unknowns u = unknowns_of(b, s);
  const double first_s = incoming_times(s).front();
  const Flight flight(u.in, b.diameter_m / 2, s);
  const Flight::State level = flight.at(first_s);
  Bounce seen;
  seen.vx_td = std::cos(s.roll_rad) * level[2] - std::sin(s.roll_rad) * level[3];
  seen.vy_td = std::sin(s.roll_rad) * level[2] + std::cos(s.roll_rad) * level[3];
  constexpr double kStep_s = 1e-6;
  seen.omega_td = (flight.turned(first_s + kStep_s) - flight.turned(first_s - kStep_s)) / (2 * kStep_s);
  return truth(seen);
}

Quantities truth(const Bounce& b) {
  Quantities q;
  const double degree = 180 / kPi;
  q[Quantity::theta_in_deg] = std::atan2(b.vy_td, b.vx_td) * degree;
  q[Quantity::theta_out_deg] = std::atan2(b.vy_lo, b.vx_lo) * degree;
  q[Quantity::vx_td_mps] = b.vx_td;
  q[Quantity::vy_td_mps] = b.vy_td;
  q[Quantity::v_td_mps] = std::sqrt(b.vx_td * b.vx_td + b.vy_td * b.vy_td);
  q[Quantity::omega_td_radps] = b.omega_td;
  q[Quantity::vx_lo_mps] = b.vx_lo;
  q[Quantity::vy_lo_mps] = b.vy_lo;
  q[Quantity::v_lo_mps] = std::sqrt(b.vx_lo * b.vx_lo + b.vy_lo * b.vy_lo);
  q[Quantity::omega_lo_radps] = b.omega_lo;
  q[Quantity::slip_lo_mps] = b.vx_lo + b.diameter_m / 2 * b.omega_lo;
  q[Quantity::e] = b.vy_lo / -b.vy_td;
  q[Quantity::mu] = (b.vx_td - b.vx_lo) / (b.vy_lo - b.vy_td);
  q[Quantity::dwell_time_ms] = b.dwell_s * 1e3;
  q[Quantity::dwell_distance_cm] = b.dwell_x_m * 1e2;
  return q;
}

namespace {

/// Every measurement's mean divided by its standard deviation.
std::vector<double> measurements(const Unknowns& u, const Bounce& b, const Setup& s) {
  std::vector<double> m;
  for (const double x : s.surface_x_m) {
    // Known abscissae: only the height of a surface point says something.
    m.push_back((u.height_px + std::tan(u.tilt) * x * s.px_per_m) / (s.surface_sd_m * s.px_per_m));
  }
  const auto leg = [&](const double* values, const Flight& flight, double t) {
    const PointPx p = project(place(flight.at(t)), u, s);
    m.push_back(p.x / (s.centre_sd_m * s.px_per_m));
    m.push_back(p.y / (s.centre_sd_m * s.px_per_m));
    m.push_back(b.diameter_m * u.px_per_m / (s.diameter_sd_m * s.px_per_m));
    m.push_back((values[4] + u.tilt + flight.turned(t)) / s.equator_sd_rad);
  };
  const Flight in(u.in, b.diameter_m / 2, s);
  const Flight out(u.out, b.diameter_m / 2, s);
  for (const double t : incoming_times(s)) leg(u.in, in, t);
  for (const double t : rebound_times(b, s)) leg(u.out, out, t - b.dwell_s);
  return m;
}

/// Time and state at which a leg's centre is a radius above the line, by iteration.
Quantities readout_of(const Unknowns& u, const Bounce& b, const Setup& s) {
  const auto cross = [&](const Flight& leg) {
    // Newton: the path is straight but for a millionth over the microseconds that a step of an unknown
    // shifts.
    double t = 0.0;
    for (int i = 0; i < 5; ++i) {
      const Flight::State state = leg.at(t);
      t -= (state[1] - b.diameter_m / 2) / state[3];
    }
    return t;
  };
  const Flight in(u.in, b.diameter_m / 2, s);
  const Flight out(u.out, b.diameter_m / 2, s);
  const double td = cross(in), lo = cross(out);
  const Flight::State at_td = in.at(td);
  const Flight::State at_lo = out.at(lo);
  Bounce seen = b;
  seen.vx_td = at_td[2], seen.vy_td = at_td[3], seen.omega_td = u.in[5];
  seen.vx_lo = at_lo[2], seen.vy_lo = at_lo[3], seen.omega_lo = u.out[5];
  seen.dwell_s = b.dwell_s + lo - td;
  seen.dwell_x_m = at_lo[0] - at_td[0];
  return truth(seen);
}

/// Steps for central differences: small against the noise, large against rounding.
constexpr double kSteps[kUnknowns] = {1e-5, 1e-2, 1.0,  1e-5, 1e-5, 1e-3, 1e-3, 1e-4,
                                      1e-2, 1e-5, 1e-5, 1e-3, 1e-3, 1e-4, 1e-2};

}  // namespace

Quantities cramer_rao(const Bounce& b, const Setup& s) {
  const Unknowns u = unknowns_of(b, s);
  const std::size_t count = measurements(u, b, s).size();
  Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(count), kUnknowns);
  Eigen::MatrixXd gradients(static_cast<Eigen::Index>(reduction::kQuantityCount), kUnknowns);
  gradients.setZero();
  for (int i = 0; i < kUnknowns; ++i) {
    Unknowns up = u;
    Unknowns down = u;
    entry(up, i) += kSteps[i];
    entry(down, i) -= kSteps[i];
    const auto m_up = measurements(up, b, s);
    const auto m_down = measurements(down, b, s);
    for (std::size_t k = 0; k < count; ++k)
      jacobian(static_cast<Eigen::Index>(k), i) = (m_up[k] - m_down[k]) / (2 * kSteps[i]);
    const Quantities q_up = readout_of(up, b, s);
    const Quantities q_down = readout_of(down, b, s);
    for (std::size_t k = 0; k < reduction::kQuantityCount; ++k) {
      const auto q = static_cast<Quantity>(k);
      if (q_up[q]) gradients(static_cast<Eigen::Index>(k), i) = (*q_up[q] - *q_down[q]) / (2 * kSteps[i]);
    }
  }
  // In the unknowns' own units the information spans twenty orders: scale it before it is inverted.
  const Eigen::VectorXd scale = jacobian.colwise().norm().cwiseInverse();
  const Eigen::MatrixXd scaled = jacobian * scale.asDiagonal();
  const Eigen::MatrixXd inverse = (scaled.transpose() * scaled).inverse();
  const Eigen::MatrixXd covariance = scale.asDiagonal() * inverse * scale.asDiagonal();
  Quantities bound;
  for (std::size_t k = 0; k < reduction::kQuantityCount; ++k) {
    const auto row = gradients.row(static_cast<Eigen::Index>(k));
    bound[static_cast<Quantity>(k)] = std::sqrt((row * covariance * row.transpose()).value());
  }
  bound[Quantity::court_pace].reset();
  return bound;
}

}  // namespace strobe::test
