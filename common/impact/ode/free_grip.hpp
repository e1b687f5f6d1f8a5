// A grip without the offset's couple in closed form, and its derivatives with respect to its constants. Pure, no
// allocation: thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/collocation_segment.hpp"
#include "common/impact/ode/normal_partials.hpp"

namespace strobe::impact::detail {

/// A grip without couple about the stretch that holds the weight, exp(-b·t)·(first·C + second·S), and how it changes with
/// b and with omega2, its stretch at the start kept.
struct FreeGrip {
  double stretch, slip;
  double stretch_by_b, slip_by_b, stretch_by_omega2, slip_by_omega2;

  FreeGrip(const CollocationConstants& c, const TangentialState& start, double t, const Oscillation& o,
           double fade) {
    const double b = c.b, first = start.stretch - c.rest, second = start.slip + b * first;
    const double sine = fade * o.sine, cosine = fade * o.cosine;
    const double sine_by = -0.5 * fade * turned_sine(c.omega2, t, o), cosine_by = -0.5 * t * sine;
    stretch = first * cosine + second * sine;
    slip = second * (cosine - b * sine) - first * (b * cosine + c.omega2 * sine);
    stretch_by_b = first * sine - t * stretch;
    slip_by_b = -(first * b + second) * sine - t * slip;
    stretch_by_omega2 = first * cosine_by + second * sine_by;
    slip_by_omega2 = second * (cosine_by - b * sine_by) - first * (b * cosine_by + sine + c.omega2 * sine_by);
  }
};

}  // namespace strobe::impact::detail
