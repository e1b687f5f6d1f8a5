// Lift-off and the motion at a few instants of a contact, at little more than the cost of lift_off(): by collocation an
// instant is the end of a segment, solved anew up to it from the start of the one in which it lies, to the tolerance of
// lift_off(). For many instants, forces and energies: ContactTrajectory.
// make() allocates; at() does not. Thread-safe for reading.
#pragma once

#include <memory>
#include <vector>

#include "common/impact/ode/contact_collocation.hpp"
#include "common/impact/ode/contact_ode.hpp"

namespace strobe::impact {

class ContactTrajectory;

/// Of the ball's centre, since touchdown.
struct ContactMotion {
  double x_m = 0.0;
  double y_m = 0.0;  ///< <= 0 in contact
  double rotation_rad = 0.0;
  Motion velocity;
};

class ContactCourse {
 public:
  /// Errors as for simulate().
  static tl::expected<ContactCourse, InputError> make(const ball::Ball& ball, const Motion& touchdown,
                                                      const ContactCoefficients& coefficients,
                                                      const ContactOptions& options = {});

  const ContactLiftOff& lift_off() const { return lift_off_; }

  /// At a time after touchdown, clamped to 0…release.
  ContactMotion at(double time_s) const;

 private:
  ContactCourse() = default;

  ContactLiftOff lift_off_;
  double tolerance_ = 0.0;
  std::optional<detail::CollocationConstants> constants_;
  std::vector<detail::SegmentStart> starts_;
  std::shared_ptr<const ContactTrajectory> by_steps_;  ///< where an integrator computed it
};

}  // namespace strobe::impact
