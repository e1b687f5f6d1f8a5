#include "tests/common/numerics/compilers/fixed_grid.hpp"

#include <array>
#include <cmath>

#include "common/ball/ball.hpp"
#include "common/contact/differentiation.hpp"
#include "common/flight/aerodynamics.hpp"
#include "common/impact/closed_form/sine_pulse.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "common/reduction/reduce.hpp"
#include "common/units/angles.hpp"

namespace strobe::numerics {

namespace {

using impact::PulseForm;

constexpr std::array<double, 5> kSpeeds{1e-6, 0.3, 17.0, 45.0, 1e3};
constexpr std::array<double, 5> kAngles_deg{0.01, 17.0, 45.0, 71.0, 89.9};
constexpr std::array<double, 6> kSpins{-1e5, -300.0, -1.0, 0.0, 165.0, 2e3};
constexpr std::array<double, 5> kRestitutions{1e-6, 0.5, 0.8, 0.95, 1.0 - 1e-9};
constexpr std::array<double, 4> kFrictions{0.0, 0.1, 0.55, 10.0};
constexpr std::array<double, 7> kFractions{0.0, 1e-9, 0.01, 0.3, 0.5, 0.9, 1.0};

class Grid {
 public:
  std::vector<GridValue> take() { return std::move(values_); }
  template <typename... T>
  void add(const char* form, T... values) {
    (values_.push_back({form, values}), ...);
  }

 private:
  std::vector<GridValue> values_;
};

void rebounds(Grid& grid) {
  const ball::Ball ball;
  for (const double speed : kSpeeds) {
    for (const double angle : kAngles_deg) {
      for (const double spin : kSpins) {
        for (const double e : kRestitutions) {
          for (const double mu : kFrictions) {
            const impact::Motion m{speed * std::cos(radians(angle)), -speed * std::sin(radians(angle)), spin};
            const auto r = *impact::grip(ball, m, {.e = e, .mu = mu, .e_x = 0.087, .offset_m = 0.003});
            grid.add("grip with e_x and offset", r.lift_off.vx_mps, r.lift_off.omega_radps, r.slip_lo_mps,
                     r.impulse_ratio, r.offset_m);
            const auto p = *impact::pulse_rebound(PulseForm::exact, ball, m, e, mu, 5e-3);
            grid.add("rebound through the pulse", p.grip_fraction, p.depth_m, p.dwell_distance_m,
                     p.max_force_n);
          }
        }
      }
    }
  }
}

void pulses(Grid& grid) {
  for (const double e : kRestitutions) {
    for (const PulseForm form : {PulseForm::exact, PulseForm::simplified}) {
      const auto pulse = *impact::SinePulse::make(form, {15.62, -6.7, e, 0.55, 5.2e-3});
      grid.add("damping of e", pulse.damping());
      for (const double fraction : kFractions) {
        const auto s = pulse.at_fraction(fraction);
        grid.add("pulse state", s.vx_mps, s.vy_mps, s.x_m, s.y_m, s.fx_n, s.fy_n, s.impulse_fraction);
        grid.add("time of an impulse", pulse.fraction_at_impulse(fraction));
      }
    }
    const auto spring = *impact::normal_spring(0.0576, std::max(e, 1e-3), 5e-3);
    grid.add("contact spring", spring.damping_ratio, spring.stiffness_npm, spring.damping_nspm);
  }
  for (const double f : {0.0, 0.046, 0.47, 1.0, 10.0}) {
    for (const double fraction : kFractions) {
      const auto p = impact::PulsePhase::at_angle(f, fraction * kPi);
      grid.add("pulse integrals", impact::impulse_integral(f, p), impact::displacement_integral(f, p),
               impact::depth_integral(f, p));
    }
  }
}

void flights(Grid& grid) {
  const auto air = flight::aerodynamics(ball::Ball{}, flight::kAirDensity_kgpm3);
  for (const double speed : kSpeeds) {
    for (const double spin : kSpins) {
      const Eigen::Vector2d v{0.9 * speed, -0.4 * speed};
      const auto f = flight::forcing(air, flight::gravity_mps2(0.1), v, spin);
      grid.add("drag and lift", f.acceleration_mps2.x(), f.acceleration_mps2.y(), f.jerk_mps3.x(),
               f.jerk_mps3.y());
      const flight::Parabola path{{0.0, 0.1}, v, flight::gravity_mps2(0.1)};
      grid.add("time at a height", path.time_falling_through_s(0.03).value_or(-1.0));
      grid.add("angles", wrap_half_turn(speed * spin));
    }
  }
}

/// A 23 degree bounce; noise of a pixel or so from a fixed sequence.
reduction::Frame frame() {
  reduction::Frame f;
  f.shot_id = 1;
  f.ball_diameter_m = 0.0651;
  f.ball_diameter_sd_m = 0.0008;
  f.centre_sd_px = 2.0;
  f.diameter_sd_px = 3.0;
  f.equator_sd_rad = 0.017;
  unsigned state = 12345;
  const auto noise = [&state](double size) {
    state = state * 1664525U + 1013904223U;
    return size * (static_cast<double>(state >> 8) / 8388608.0 - 1.0);
  };
  for (const double x : {-800.0, -400.0, 700.0, 1000.0}) f.surface_px.push_back({x, noise(3.0)});
  for (int i = 0; i < 10; ++i) {
    const bool incoming = i < 5;
    const double t = (incoming ? i - 4.4 : i - 3.4) * 3e-3 - (incoming ? 0.0 : 5.2e-3);
    const double x = incoming ? 15.62 * t : 0.063 + 8.84 * t;
    const double y = 0.03255 + (incoming ? -6.71 : 5.76) * t;
    reduction::BallImage image;
    image.time_s = (incoming ? i : i + 1) * 3e-3;
    image.leg = incoming ? reduction::Leg::incoming : reduction::Leg::rebound;
    image.centre_px = {4000.0 * x + noise(3.0), 4000.0 * y + noise(3.0)};
    image.diameter_px = 260.4 + noise(4.0);
    image.equator_rad = incoming ? 0.3 + 2.6 * t : 0.1 - 313.0 * t;
    f.images.push_back(image);
  }
  return f;
}

void reductions(Grid& grid) {
  const auto readout = *reduction::reduce(frame(), reduction::Estimator::best);
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto quantity = static_cast<reduction::Quantity>(i);
    if (readout.value[quantity]) grid.add("reduction, values", *readout.value[quantity]);
    if (readout.sd[quantity]) grid.add("reduction, sd", *readout.sd[quantity]);
  }
}

void contacts(Grid& grid) {
  const std::array<double, 9> t{0.0, 0.11, 0.2, 0.34, 0.47, 0.6, 0.72, 0.9, 1.0};
  const std::array<double, 9> y{0.0, -0.06, -0.1, -0.16, -0.19, -0.18, -0.13, -0.05, 0.0};
  const auto fit = *contact::fit_cubic(t, y);
  for (std::size_t i = 0; i < 4; ++i) grid.add("cubic fit", fit.coefficients[i], (*fit.standard_errors)[i]);
  for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-12}) {
    for (const double spin : kSpins) {
      const auto s =
          *impact::lift_off(ball::Ball{}, {15.62, -6.7, spin}, impact::ContactCoefficients{},
                            {.method = impact::ContactMethod::collocation, .tolerance = tolerance});
      grid.add("contact by collocation", s.lift_off.vx_mps, s.lift_off.vy_mps, s.lift_off.omega_radps,
               s.dwell_distance_m, s.rotation_rad);
    }
  }
  for (const double spin : kSpins) {
    const auto s = *impact::simulate(ball::Ball{}, {15.62, -6.7, spin}, impact::ContactCoefficients{});
    grid.add("contact ODE", s.lift_off.vx_mps, s.lift_off.vy_mps, s.lift_off.omega_radps, s.max_force_n,
             s.dwell_distance_m, s.rotation_rad);
  }
}

}  // namespace

std::vector<GridValue> fixed_grid() {
  Grid grid;
  rebounds(grid);
  pulses(grid);
  flights(grid);
  reductions(grid);
  contacts(grid);
  return grid.take();
}

}  // namespace strobe::numerics
