// Which outlines are the ball's images: odds of limb, size and path, then path, ghosts and spacing. What is
// left out is added to `rejected`. Deterministic for any number of threads; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/outliers/limb_agreement.hpp"
#include "host/digitize/path/path.hpp"
#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

// The ball's size on a photograph, estimated from all its images. It may change steadily across the
// photograph, where the plane of flight is not square to the camera and no calibration corrects it.
// Deterministic; thread-safe; allocates.

struct SizeModel {
  double diameter = 0.0;  ///< plane px, at x = 0
  double slope = 0.0;     ///< per px of x
  double sd = 0.0;        ///< of the diameter where the balls are
  double spread = 0.0;    ///< sd of single balls about it, beyond what their own sds explain

  double at(double x) const { return diameter + slope * x; }
};

/// Of single balls of one size, of the diameter: what lies under a limb moves it, and sizes do not change
/// evenly along a path.
inline constexpr double kSdOfDiameter = 0.02;

/// Median diameter, with the median slope from 5 outlines on (Theil 1950, Sen 1968). At least one outline.
SizeModel fit_size_model(std::span<const Outline> outlines);

// Images of a leg that are too close to each other: the ball is at one place at a time and flies as steadily
// as the lamps flash. Deterministic; thread-safe; allocates.

struct TooClose {
  int index = 0;      ///< of the rejected point
  int neighbour = 0;  ///< of the better one next to it
  double distance_px = 0.0;
};

/// Of two neighbours less than half the leg's median step apart, the less probable one if it is rather no
/// ball: where the flashes' times are known by its probability, as steps may be unequal on purpose, or if no
/// two flashes are close enough to explain it in any case; where they are not, on straight legs, the less
/// likely the shorter the step is, and less than a tenth of the median one in any case; along curved ones by
/// its probability alone. Legs of fewer than 4 images are not checked.
std::vector<TooClose> find_too_close(const Path& path, std::span<const PathPoint> points,
                                     std::span<const double> probabilities,
                                     std::span<const double> flash_times_s);

struct SelectedBySize {
  std::vector<Outline> outlines;
  SizeModel size;  ///< of the certain balls; of no outlines none
};

/// Leaves out what limb and size say is no ball, even should a path lead to it.
SelectedBySize select_by_size(const Photograph& photograph, const PlaneMap& map,
                              std::vector<Outline> outlines, const std::optional<SurfaceLine>& surface,
                              std::vector<Unmeasured>& rejected);

/// Likewise, then what lies off the path, ghosts, what is nearer than steps allow, and doubtful contacts.
/// Sets each outline's probability.
std::vector<Outline> select_by_path(const Photograph& photograph, const PlaneMap& map,
                                    std::vector<Outline> outlines, const std::optional<SurfaceLine>& surface,
                                    const FlightFacts& facts, std::vector<Unmeasured>& rejected);

}  // namespace strobe::digitize
