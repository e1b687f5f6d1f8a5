// What balls are expected to do before they are thrown: their motion at touchdown, their bounce and where
// they go, with the spread from ball to ball. Axes and signs as in a readout (common/reduction/readout.hpp).
// Plain values and pure functions; thread-safe.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/ball/ball.hpp"
#include "common/data/ball_kind.hpp"
#include "common/flight/aerodynamics.hpp"
#include "common/impact/closed_form/rebound.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/reduction/readout.hpp"
#include "common/result.hpp"

namespace strobe::host {

/// Mean and standard deviation from ball to ball.
struct Spread {
  double mean = 0.0;
  double sd = 0.0;  ///< >= 0
};

/// What is known of the balls to come.
struct ExpectedBall {
  Spread speed_mps{17.0, 0.0};   ///< at touchdown; mean 0.5 to 100
  Spread angle_rad{-0.41, 0.0};  ///< of its path against the surface, below 0; mean -90 to -1 degrees
  Spread spin_radps{0.0, 0.0};   ///< backspin positive
  Spread e{0.75, 0.0};           ///< normal restitution; mean above 0 to 1
  Spread mu{impact::ContactCoefficients{}.mu, 0.0};  ///< coefficient of friction, >= 0
  Spread dwell_s{0.005, 0.0};                        ///< 0.1 to 50 ms
  ball::Ball ball{};
  double air_density_kgpm3 = flight::kAirDensity_kgpm3;
  std::optional<balls::Kind> kind{};  ///< absent: a tennis ball

  flight::AirLaw air_law() const { return kind ? kind->air : flight::AirLaw{}; }
};

/// What is wrong with it, naming the quantity; nullopt: nothing.
std::optional<std::string> problem_of(const ExpectedBall& ball);

/// Standard normal deviates, or places of a quasi-random sequence, of one ball.
struct BallDraw {
  double speed = 0.0, angle = 0.0, spin = 0.0, e = 0.0, mu = 0.0, dwell = 0.0;
  double arrival = 0.0;  ///< of the instant of touchdown
  double spot = 0.0;     ///< of the place of touchdown
  double equator_rad = 0.0;
};

/// `count` of them, quasi-random and of mean 0 and standard deviation 1, so that a few stand for many: the
/// same each time. Source: I. M. Sobol, USSR Comput. Math. Math. Phys. 7 (1967).
std::vector<BallDraw> ball_draws(std::size_t count);

/// One ball's flight, bounce and flight. Its time is 0 at touchdown, its place x = 0 there.
class BallCourse {
 public:
  /// Lift-off by the contact's mechanics (common/impact/ode); numbers beyond its ranges are taken to their
  /// edge. `gravity_mps2`: in the surface's axes.
  static Result<BallCourse> make(const ExpectedBall& expected, const BallDraw& draw,
                                 const Eigen::Vector2d& gravity_mps2);

  struct Place {
    Eigen::Vector2d centre_m;  ///< from the point of touchdown on the surface, y up
    double speed_mps = 0.0;
    double equator_rad = 0.0;  ///< from that at touchdown
    bool in_contact = false;
    bool beyond = false;  ///< past the top and down again to the surface: the next bounce
  };
  Place at(double time_s) const;

  const impact::Motion& touchdown() const { return touchdown_; }
  const impact::Motion& lift_off() const { return lift_off_; }
  double dwell_s() const { return dwell_s_; }

 private:
  BallCourse() = default;

  impact::Motion touchdown_, lift_off_;
  double dwell_s_ = 0.0, dwell_distance_m_ = 0.0, radius_m_ = 0.0;
  flight::Flight approach_, departure_;
};

}  // namespace strobe::host
