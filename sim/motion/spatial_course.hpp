// Motion between touchdown and lift-off of a ball whose velocity or spin is not in the plane. Axes, touchdown
// and lift-off as in ball_path.hpp. By the scene's law: the mechanics in three dimensions
// (common/impact/spatial) to their release and then free, or their closed form for the law `grip`, all of
// whose velocities and spins change as the damped sine's impulse grows. Plain values, thread-safe; allocates.
#pragma once

#include <optional>
#include <vector>

#include "common/impact/spatial/spatial_contact.hpp"
#include "sim/motion/contact_path.hpp"

namespace strobe::sim {

class SpatialCourse {
 public:
  /// For a model that refusal_in_space() does not refuse.
  static Result<SpatialCourse> make(const Scene& scene, const ShotConditions& thrown, const Model& model);

  /// From touchdown (0) to lift-off.
  ContactPath::State at(double time_s) const;
  const LiftOff& lift_off() const { return end_; }

 private:
  SpatialCourse() = default;
  static Result<SpatialCourse> by_mechanics(const Scene& scene, const ShotConditions& thrown,
                                            const Model& model);
  static Result<SpatialCourse> by_sine(const Scene& scene, const ShotConditions& thrown, const Model& model);
  ContactPath::State mechanics_at(double time_s) const;
  ContactPath::State sine_at(double time_s) const;
  Eigen::Vector3d sine_spin_at(double time_s) const;
  void end_as(const ContactPath::State& state);

  LiftOff end_;
  // By the mechanics:
  std::optional<impact::SpatialContact> mechanics_;
  ContactPath::Release release_;
  // By the sine:
  std::optional<ContactPath> sine_;  ///< of what is in the plane
  impact::SpatialMotion touchdown_, change_;
  double step_s_ = 0.0;
  std::vector<Turn> turned_;  ///< since touchdown, at every step
};

}  // namespace strobe::sim
