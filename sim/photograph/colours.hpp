// What a colour sensor's pixels see of a scene by xenon light. Pure; thread-safe.
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "common/image/raster.hpp"
#include "sim/scene/photograph_settings.hpp"

namespace strobe::sim {

/// Light on red, green and blue pixels, over that which a grey sensor would have.
using Colour = std::array<float, 3>;

/// Of things without a colour: daylight's balance on usual sensors, whose files give gains of 2 and 1.5.
inline constexpr Colour kNeutral{0.5F, 1.0F, 0.67F};

/// A tennis ball's felt reflects .62, .80 and .22 of red, green and blue; others are white. The green pixels
/// have as much light as a grey sensor's.
Colour ball_colour(BallSurface surface);

/// RGGB, with the black level and range of the settings.
image::Mosaic mosaic_of(const PhotographSettings& settings);

/// Adds to the light of all else (CV_32FC1), which has no colour, that of the balls; each pixel's of its own
/// colour.
void colour_pixels(const image::Mosaic& mosaic, const Colour& ball, const cv::Mat& balls, cv::Mat& light);

}  // namespace strobe::sim
