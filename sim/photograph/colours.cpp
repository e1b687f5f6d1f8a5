#include "sim/photograph/colours.hpp"

#include <cmath>

namespace strobe::sim {

Colour ball_colour(BallSurface surface) {
  if (surface != BallSurface::felt) return kNeutral;
  constexpr Colour kFelt{0.62F / 0.80F, 1.0F, 0.22F / 0.80F};
  return {kFelt[0] * kNeutral[0], kFelt[1] * kNeutral[1], kFelt[2] * kNeutral[2]};
}

image::Mosaic mosaic_of(const PhotographSettings& settings) {
  image::Mosaic mosaic;
  mosaic.white = (1 << settings.bits) - 1;
  mosaic.black = static_cast<int>(std::lround(settings.black_level * mosaic.white));
  return mosaic;
}

void colour_pixels(const image::Mosaic& mosaic, const Colour& ball, const cv::Mat& balls, cv::Mat& light) {
  for (int y = 0; y < light.rows; ++y) {
    const auto* of_balls = balls.ptr<float>(y);
    auto* all = light.ptr<float>(y);
    for (int x = 0; x < light.cols; ++x) {
      const std::size_t colour = mosaic.colour(x, y);
      all[x] = kNeutral[colour] * all[x] + ball[colour] * of_balls[x];
    }
  }
}

}  // namespace strobe::sim
