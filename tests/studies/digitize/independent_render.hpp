// A second renderer, to judge by what the first one cannot: it shares the shot (where the ball is at each flash) and
// nothing of how a photograph is made. Rough felt after Oren and Nayar, other lamps, wall and plate; a lens with glare;
// a colour sensor with a Bayer mosaic and uneven pixels; a flash with a tail; JPEG. Its own geometry, its own truth.
// Deterministic by the take's seed; thread-safe; allocates.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "sim/rig/exposure.hpp"
#include "sim/scene/scene.hpp"
#include "tests/studies/digitize/score.hpp"

namespace strobe::studies::digitize {

/// What the scene does not say.
struct IndependentLook {
  double noise = 1.0;  ///< of the sensor, over the usual
  std::optional<double> ball_at_rest_m{};  ///< a second ball lies on the plate there, from where the first touches down
};

struct IndependentTruth {
  std::vector<TrueImage> images;
  std::vector<TrueImage> others;               ///< of second balls
  std::vector<double> times_s;                 ///< of the images, from the first pulse's edge
  std::vector<reduction::PointPx> surface_px;  ///< two points of the surface
  std::array<double, 3> viewpoint_px{};        ///< foot of the lens on the plane of flight, its distance
};

/// Of the photograph that the same arguments render; nothing is rendered here.
IndependentTruth independent_truth(const sim::Scene& scene, const sim::Exposure& exposure,
                                   std::uint64_t seed, const IndependentLook& look = {});

/// CV_16UC3, blue first.
cv::Mat render_independently(const sim::Scene& scene, const sim::Exposure& exposure, std::uint64_t seed,
                             const IndependentLook& look);

}  // namespace strobe::studies::digitize
