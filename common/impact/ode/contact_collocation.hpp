// Implementation of contact_ode.hpp: the contact by collocation. The normal motion is a damped sine in closed
// form (normal_motion.hpp); gripping or slipping, all of the tangential motion follows from one unknown, the
// impulse of the offset's couple (collocation_segment.hpp), which is found as a fixed point on Gauss–Legendre
// nodes (segment_solver.hpp). A segment ends where friction changes its law or the footprint its own; its
// length is halved until the last Legendre coefficients are small enough. Pure, no allocation: thread-safe,
// real-time safe.
#pragma once

#include <optional>
#include <vector>

#include "common/impact/ode/collocation_segment.hpp"

namespace strobe::impact::detail {

/// What collocation gives without looking for the times and sums that ContactSummary has besides.
struct CollocatedContact {
  double tau = 0.0;  ///< of release
  double rate = 0.0;
  TangentialState release;
  std::optional<double> first_grip_tau;  ///< end of the first slip
  std::optional<double> slip_zero_tau;   ///< coarsely: the end of the segment where the slip changes its sign
  bool slip_zero_first = false;          ///< before the first grip
  bool started_gripping = false;
  int segments = 0;
  int evaluations = 0;  ///< of nodes

  /// The end of skidding as ContactSummary has it.
  std::optional<double> skid_to_grip_tau() const {
    return started_gripping && slip_zero_first ? std::optional(0.0) : first_grip_tau;
  }
  Regime regime() const { return first_grip_tau || slip_zero_tau ? Regime::grips : Regime::slides; }
};

/// From where a segment was solved.
struct SegmentStart {
  ContactMode mode = ContactMode::grips;
  double x = 0.0;
  NormalState from;
  TangentialState start;
};

/// Whether the options ask for collocation, to a tolerance that there is.
inline bool collocates(const ContactOptions& options) {
  return options.method == ContactMethod::collocation && options.tolerance >= 1e-12 &&
         options.tolerance <= 1e-3;
}

/// Leaves out what only a summary has.
ContactLiftOff lift_off_of(const CollocationConstants& constants, const CollocatedContact& contact);

ContactSummary summary_of(const CollocationConstants& constants, const CollocatedContact& contact,
                          const Segments& segments);

/// Returns nullopt where the integrator has to take over: a weight, a reference speed, a stiffness for which
/// the segments would be too many. `segments`, if not null, receives them; `along`: the error control is that
/// of every point of a segment, not of its end, and the segments have their coefficients; otherwise only
/// their samples, which go beyond where friction changed its law.
std::optional<CollocatedContact> collocate(const CollocationConstants& constants, double tolerance,
                                           bool along, Segments* segments);

/// The same without segments, but for where each begins. Allocates for those.
std::optional<CollocatedContact> collocate(const CollocationConstants& constants, double tolerance,
                                           std::vector<SegmentStart>& starts);

/// The state at `tau` of the segment that begins with `start`, to the tolerance of the end of one.
SegmentPoint point_at(const CollocationConstants& constants, double tolerance, const SegmentStart& start,
                      double tau);

}  // namespace strobe::impact::detail
