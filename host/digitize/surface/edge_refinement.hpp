// A straight edge (edge_line.hpp) once more, by fits of a blurred step to profiles across it. Deterministic;
// thread-safe; allocates.
#pragma once

#include <optional>
#include <span>

#include "host/digitize/surface/edge_line.hpp"

namespace strobe::digitize {

// A blurred step of light in the samples of one profile across an edge. Where light saturates the sensor, the
// samples say only that there is more: they are censored, as the steepest part of such an edge is cut off and
// what is left lies to the dark side. Pure; thread-safe; no allocation.

enum class Blur { normal, logistic };

struct StepShape {
  Blur blur = Blur::normal;
  double sd_px = 1.0;  ///< of the blur apart from the pixel's own width, > 0
};

struct StepFit {
  double at = 0.0;  ///< index of the samples
  double background = 0.0;
  double step = 0.0;      ///< intensity, > 0
  double squares = 0.0;   ///< of the residuals
  double variance = 0.0;  ///< of `at`, for samples of variance 1
};

/// The samples within 3 sd and 3 px of `start`, dark first. `saturation`: samples of that intensity or more
/// count only where the step is below them. Returns nullopt for fewer than 5 samples within, if there is no
/// step, or if it is farther than 3 px from the start.
std::optional<StepFit> fit_step(std::span<const double> intensity, double saturation, double start,
                                const StepShape& shape);

/// The edge's place, slope and standard deviations where a step fits 12 profiles or more, else `edge` as it
/// is, less certain where light saturates. A saturated side's light is not needed: the steepest rise of such
/// an edge lies off it, the step that fits what is not saturated does not.
EdgeLine refine_edge_line(const Photograph& photograph, const PlaneMap& map, const OcclusionMask& occluded,
                          const EdgeLine& edge);

}  // namespace strobe::digitize
