// Where along a step a function of the contact's state passes zero: the inside of contact_ode.hpp.
// Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include <optional>

#include "common/impact/ode/contact_integrator.hpp"

namespace strobe::impact::detail {

/// The functions that are watched. The first six end a step where they become negative; of the others the
/// time is noted where they change sign.
enum class Watched {
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

struct Value {
  double value;
  double noise;  ///< what rounding may have made of it
};

Value watch(const System& system, Watched what, ContactMode mode, const State& z);

/// A step taken, for looking into it. Call prepare() before find_crossing().
struct TakenStep {
  const System& system;
  ContactMethod method;
  ContactStep step;
  State end;
  State end_slope;
  int* evaluations;
  std::array<State, 3> between{};  ///< glances at its quarters

  void prepare();
  /// State a part of the step's size on, with the method's full order.
  State at(double part_size) const;
  /// Cubic through both ends, for finding where to look; the components that are watched.
  State glance(double fraction) const;
};

/// First part size at which the function has become negative (beyond its noise), located to rounding: 0 if it
/// is negative from the start, empty if it does not.
std::optional<double> find_crossing(const TakenStep& taken, Watched what);

/// Part size at which the function changes sign between the ends of the step shortened to `size`, if it
/// does. `sign` picks the direction: +1 rising, -1 falling, 0 both.
std::optional<double> find_sign_change(const TakenStep& taken, Watched what, double size, const State& end,
                                       int sign);

}  // namespace strobe::impact::detail
