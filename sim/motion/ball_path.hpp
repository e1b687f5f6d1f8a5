// The true path of one ball: flight to the surface, contact, flight away from it, and so on for as many
// bounces as the scene says. Touchdown, lift-off, rebound and dwell are the first bounce's. Readouts are
// compared with it; it shares no code with the reduction. Axes of the surface: x along it in the direction of
// travel, y up from it, z towards the camera, origin under the centre at touchdown; spins right-handed,
// omega_radps is the one about z (backspin positive).
// Touchdown and lift-off: the centre is one radius above the surface. Plain values, thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/impact/closed_form/rebound.hpp"
#include "common/result.hpp"
#include "sim/motion/contact_path.hpp"
#include "sim/motion/flight.hpp"
#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

struct BallState {
  double x_m = 0.0;
  double y_m = 0.0;  ///< of the centre of mass, above the surface
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double omega_radps = 0.0;
  double equator_rad = 0.0;
  double top_drop_m = 0.0;  ///< by how much the ball's top is nearer to the surface than one diameter, >= 0
  // Of a shot that is not planar:
  double z_m = 0.0;  ///< towards the camera, from the plane in which the ball touched down
  double vz_mps = 0.0;
  double omega_x_radps = 0.0, omega_y_radps = 0.0;
  /// Since touchdown, besides equator_rad, which then stays. The ball's own axes, in which the line lies near
  /// x and z, are turned by equator_rad about z, then by this.
  Turn turned = Turn::Identity();

  Eigen::Matrix3d attitude() const {
    return turned.toRotationMatrix() *
           Eigen::AngleAxisd(equator_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
};

class BallPath {
 public:
  /// Fails if the conditions are outside the impact models' ranges or the ball's weight keeps it on the
  /// surface. `reduced`: of calibrate(), for a model that needs it (contact_path.hpp); nullptr: calibrated
  /// here.
  static Result<BallPath> make(const Scene& scene, const ShotConditions& thrown,
                               const Model& model = Model::full(), const ReducedContact* reduced = nullptr);

  /// The state `time_s` after touchdown (negative: before): flight, contact (contact_path.hpp), flight.
  BallState at(double time_s) const;

  /// Mean of the states over the `duration_s` (0: none) from `from_s` on, but for speeds and spin, which are
  /// those of its middle. By Gauss's rule of three points, exact for the fifth power of time.
  BallState mean_over(double from_s, double duration_s) const { return lit(from_s, duration_s).mean; }

  /// The state where a light of that duration begins, and its mean.
  struct Lit {
    BallState begin, mean;
  };
  Lit lit(double from_s, double duration_s) const;

  struct Place {
    double x_m = 0.0, y_m = 0.0;
  };
  /// Of the centre in flight after the contact, within a centimetre, at a fifth of at()'s cost; else that of
  /// at().
  Place roughly_at(double time_s) const;

  /// Whether the ball is in the air there with its centre lower than at touchdown: it would have met the
  /// surface once more than is simulated.
  bool beyond_last_bounce(double time_s, const BallState& state) const {
    if (next_ && time_s >= next_at_s_) return next_->beyond_last_bounce(time_s - next_at_s_, state);
    return (time_s < 0.0 || time_s > dwell_s()) && state.y_m < radius_m_;
  }

  /// Whether the ball has met the surface a second time by then.
  bool bounced_again(double time_s) const { return next_ && time_s >= next_at_s_; }

  /// Whether the ball stays in its plane and spins across it.
  bool planar() const { return conditions_.planar(); }
  const ShotConditions& conditions() const { return conditions_; }
  const LiftOff& lift_off() const { return contact_.lift_off(); }

  const impact::Motion& touchdown() const { return conditions_.touchdown; }
  const impact::Rebound& rebound() const { return contact_.lift_off().rebound; }
  double dwell_s() const { return contact_.lift_off().dwell_s; }
  double dwell_distance_m() const { return contact_.lift_off().displacement_m; }
  double spot_m() const { return conditions_.spot_m; }
  double off_plane_m() const { return conditions_.off_plane_m; }

  /// When (before touchdown, hence negative) the centre passes a point `distance_m` before that of touchdown.
  /// Returns nullopt if it never does.
  std::optional<double> time_at_distance_s(double distance_m) const;

 private:
  BallPath(const Scene& scene, const ShotConditions& thrown, const Model& model, ContactPath contact);
  BallState contact_at(double time_s) const;
  BallState in_flight(const FlightState& s, bool rebounding) const;
  Flight flight_from(const Scene& scene, const Model& model, bool rebounding) const;
  std::array<BallState, 4> at(const Flight::Instants& time_s) const;
  void bounce_again(const Scene& scene, const Model& model, const ReducedContact* reduced, int times);

  ShotConditions conditions_;
  ContactPath contact_;
  double radius_m_;
  double top_drop_ratio_;
  Flight approach_;   ///< backwards from touchdown
  Flight departure_;  ///< from lift-off on
  /// From the next touchdown on, in its own time and place; empty: there is none.
  std::shared_ptr<const BallPath> next_;
  double next_at_s_ = 0.0, next_x_m_ = 0.0, next_z_m_ = 0.0;
  Turn next_turned_ = Turn::Identity();
};

}  // namespace strobe::sim
