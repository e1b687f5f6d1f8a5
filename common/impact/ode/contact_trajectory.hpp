// Dense output of the contact ODE. By an integrator the steps of simulate() are stored, and a state between
// two of them is one step of the method from the one before it, as accurate as the steps themselves. By
// collocation the segments are stored, solved to the tolerance along their whole length, and a state is that
// of their closed forms. make() allocates for the steps; at() does not allocate. Thread-safe for reading.
#pragma once

#include <memory>
#include <vector>

#include "common/impact/ode/collocation_segment.hpp"
#include "common/impact/ode/contact_collocation.hpp"
#include "common/impact/ode/contact_integrator.hpp"
#include "common/impact/ode/contact_ode.hpp"

namespace strobe::impact {

struct ContactState {
  double time_s = 0.0;
  double x_m = 0.0;           ///< displacement of the centre since touchdown
  double y_m = 0.0;           ///< height of the centre less that at touchdown: <= 0 in contact
  double rotation_rad = 0.0;  ///< since touchdown, counter-clockwise
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double omega_radps = 0.0;
  double fx_n = 0.0;  ///< on the ball
  double fy_n = 0.0;  ///< >= 0
  ContactMode mode = ContactMode::grips;
  double slip_mps = 0.0;             ///< vx + R·omega
  double offset_m = 0.0;             ///< of the normal force ahead of the centre
  double mechanical_energy_j = 0.0;  ///< kinetic, springs, weight: never grows
  double dissipated_j = 0.0;         ///< by dashpots, sliding and offset since touchdown
};

class ContactTrajectory {
 public:
  /// Errors as for simulate().
  static tl::expected<ContactTrajectory, InputError> make(const ball::Ball& ball, const Motion& touchdown,
                                                          const ContactCoefficients& coefficients,
                                                          const ContactOptions& options = {});

  const ContactSummary& summary() const { return summary_; }

  /// The state at a time after touchdown, clamped to 0…release. At an event: the state after it, but at
  /// release the last in contact.
  ContactState at(double time_s) const;

 private:
  ContactTrajectory() = default;
  static std::optional<ContactTrajectory> by_collocation(const detail::System& system, double tolerance);
  detail::State state_by_collocation(double tau, ContactMode& mode) const;
  ContactState state_of(const detail::State& z, double tau, ContactMode mode) const;

  detail::System system_;
  ContactSummary summary_;
  std::vector<detail::ContactStep> steps_;
  std::optional<detail::CollocationConstants> constants_;  ///< with segments instead of steps
  std::vector<detail::Segment> segments_;
};

// Lift-off and the motion at a few instants of a contact, at little more than the cost of lift_off(): by
// collocation an instant is the end of a segment, solved anew up to it from the start of the one in which it
// lies, to the tolerance of lift_off(). For many instants, forces and energies: ContactTrajectory. make()
// allocates; at() does not. Thread-safe for reading.

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
