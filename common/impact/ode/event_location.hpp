// Implementation of contact_ode.hpp: locates where along a step a function of the contact's state passes
// zero. Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <optional>

#include "common/impact/ode/contact_integrator.hpp"

namespace strobe::impact::detail {

/// The first six end a step where they become negative; of the others the times of their sign changes are
/// recorded.
enum class EventFunction {
  release,            ///< N
  hold_forward,       ///< gripping: mu·N - F
  hold_backward,      ///< gripping: mu·N + F
  sliding,            ///< slipping: speed of the slip in its direction (times c_t where there is a dashpot)
  footprint_full,     ///< R - y: the footprint stops growing
  footprint_shrinks,  ///< y - R
  friction,           ///< gripping: F
  depth_rate,
  force_rate,     ///< dN/dt
  friction_rate,  ///< dF/dt
  slip,           ///< vx + R·omega
};

struct EventValue {
  double value;
  double noise;  ///< bound of its rounding error
};

EventValue event_value(const System& system, EventFunction function, ContactMode mode, const State& z);

/// Dense output of one step. Call interpolate_quarters() before find_crossing().
struct DenseStep {
  const System& system;
  ContactStep step;
  State end;
  State end_derivative;
  int* evaluations;
  std::array<State, 3> quarters{};  ///< cubic interpolants at 1/4, 1/2, 3/4

  void interpolate_quarters();
  /// State `size` after the step's start, by one step.
  State at(double size) const;
  /// Cubic Hermite interpolant of the components that event functions use, to bracket their zeros.
  State interpolate(double fraction) const;
};

/// First size at which the function has become negative (beyond its noise), located to rounding: 0 if it is
/// negative at the start. Returns nullopt if it does not become negative.
std::optional<double> find_crossing(const DenseStep& dense, EventFunction function);

/// Size at which the function changes sign between the ends of the step shortened to `size`. `sign` selects
/// the direction: +1 rising, -1 falling, 0 both. Returns nullopt if it does not change sign.
std::optional<double> find_sign_change(const DenseStep& dense, EventFunction function, double size,
                                       const State& end, int sign);

}  // namespace strobe::impact::detail
