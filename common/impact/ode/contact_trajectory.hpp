// The course of a contact, to be asked at any time: the steps that simulate() takes are kept, and a state
// between two of them is one step of the method from the nearest before it, so that it is as exact as the
// steps themselves. Allocates for the steps (none once the vector is large enough); at() allocates nothing.
// Thread-safe for reading.
#pragma once

#include <vector>

#include "common/impact/ode/contact_integrator.hpp"
#include "common/impact/ode/contact_ode.hpp"

namespace strobe::impact {

struct ContactState {
  double time_s = 0.0;
  double x_m = 0.0;        ///< of the centre, since touchdown
  double y_m = 0.0;        ///< height of the centre less that at touchdown: <= 0 in contact
  double angle_rad = 0.0;  ///< turned since touchdown, counter-clockwise
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double omega_radps = 0.0;
  double fx_n = 0.0;  ///< on the ball
  double fy_n = 0.0;  ///< >= 0
  ContactMode mode = ContactMode::grips;
  double slip_mps = 0.0;      ///< vx + R·omega
  double stretch_m = 0.0;     ///< of the tangential spring
  double offset_m = 0.0;      ///< of the normal force ahead of the centre
  double mechanical_j = 0.0;  ///< kinetic, springs' and (with gravity) weight's: never grows
  double lost_j = 0.0;        ///< to dampers, sliding and offset since touchdown
};

class ContactTrajectory {
 public:
  /// Errors as for simulate().
  static tl::expected<ContactTrajectory, InputError> make(const ball::Ball& ball, const Motion& touchdown,
                                                          const ContactCoefficients& coefficients,
                                                          const ContactOptions& options = {});

  const ContactSummary& summary() const { return summary_; }

  /// The state at a time from touchdown (0) to release; the nearest of them outside. At an event: the state
  /// after it, but at release the last in contact.
  ContactState at(double time_s) const;

  /// Ends of the steps taken, touchdown and release included: an event is one of them.
  std::vector<double> step_times_s() const;

 private:
  ContactTrajectory() = default;
  ContactState state_of(const detail::State& z, double tau, ContactMode mode) const;

  detail::System system_;
  ContactMethod method_ = ContactMethod::dormand_prince;
  ContactSummary summary_;
  std::vector<detail::ContactStep> steps_;
};

}  // namespace strobe::impact
