// The true path of one ball: flight through the air, the rebound, and what happens in between. This is the
// truth that readouts are held against; it shares no code with the reduction. Axes of the surface: x along it
// in the direction of travel, y up from it, origin under the centre at touchdown; spin counter-clockwise
// (backspin) positive. Touchdown and lift-off: the centre is one radius above the surface. Plain values,
// thread-safe.
#pragma once

#include <cstdint>
#include <optional>

#include "common/impact/rebound.hpp"
#include "common/impact/sine_pulse.hpp"
#include "common/result.hpp"
#include "sim/rig/flight.hpp"
#include "sim/rig/scene.hpp"

namespace strobe::sim {

/// What a shot's ball is like: the scene's means with this shot's draws.
struct Throw {
  impact::Motion touchdown;
  impact::Coefficients coefficients;
  double dwell_s = 0.0;      ///< touchdown to lift-off
  double equator_rad = 0.0;  ///< angle of the equator line at touchdown
  double lag_s = 0.0;        ///< trigger to touchdown
  double spot_m = 0.0;       ///< point of touchdown, along the surface from where the camera has its origin
};

Throw draw_throw(const Scene& scene, std::uint64_t seed, int shot);

struct BallState {
  double x_m = 0.0;
  double y_m = 0.0;  ///< of the centre of mass, above the surface
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double omega_radps = 0.0;
  double equator_rad = 0.0;
  double top_drop_m = 0.0;  ///< by how much the ball's top is nearer to the surface than one diameter, >= 0
};

class BallPath {
 public:
  /// Fails if the throw is outside the impact models' ranges.
  static Result<BallPath> make(const Scene& scene, const Throw& thrown);

  /// The state `time_s` after touchdown (negative: before).
  ///
  /// In contact the net force (weight included) is the exact damped sine pulse, friction and spin follow its
  /// impulse. The pulse ends, as for any damped contact, while the ball is still flattened; it then moves
  /// freely and lifts off, by the definition above, a little later. The pulse's length is chosen such that
  /// touchdown to lift-off takes the dwell time.
  BallState at(double time_s) const;

  const impact::Motion& touchdown() const { return thrown_.touchdown; }
  const impact::Rebound& rebound() const { return rebound_; }
  double dwell_s() const { return thrown_.dwell_s; }
  double dwell_distance_m() const { return contact_at(thrown_.dwell_s).x_m; }
  double spot_m() const { return thrown_.spot_m; }

  /// When (before touchdown, hence negative) the centre passes a point `distance_m` ahead of that of
  /// touchdown; nothing if it never does.
  std::optional<double> time_at_distance_s(double distance_m) const;

 private:
  BallPath(const Scene& scene, const Throw& thrown, const impact::Rebound& rebound,
           const impact::SinePulse& pulse);
  BallState contact_at(double time_s) const;

  Throw thrown_;
  impact::Rebound rebound_;
  impact::SinePulse pulse_;
  double radius_m_;
  double top_drop_ratio_;
  Flight approach_;   ///< backwards from touchdown
  Flight departure_;  ///< from lift-off on
};

}  // namespace strobe::sim
