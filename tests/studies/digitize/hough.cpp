#include "tests/studies/digitize/hough.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace strobe::studies::digitize {

namespace {

/// Stretched so that all but the brightest of a thousand pixels fit into 8 bits.
cv::Mat eight_bits(const cv::Mat& light) {
  std::vector<float> values(light.begin<float>(), light.end<float>());
  const auto high =
      values.begin() + static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), high, values.end());
  cv::Mat picture;
  light.convertTo(picture, CV_8U, 255.0 / std::max(1e-6F, *high));
  return picture;
}

}  // namespace

std::vector<HoughSettings> hough_trials() {
  std::vector<HoughSettings> trials;
  for (const double edge : {60.0, 120.0})
    for (const double support : {10.0, 15.0, 20.0, 30.0})
      trials.push_back({.alternative = false, .reduction = 4, .edge = edge, .support = support});
  for (const double support : {0.3, 0.5, 0.7, 0.85})
    trials.push_back({.alternative = true, .reduction = 4, .edge = 200.0, .support = support});
  for (const double support : {20.0, 30.0})
    trials.push_back({.alternative = false, .reduction = 2, .edge = 60.0, .support = support});
  return trials;
}

std::string text_of(const HoughSettings& s) {
  return fmt::format("{} at 1/{}, param1 {}, param2 {}",
                     s.alternative ? "HOUGH_GRADIENT_ALT" : "HOUGH_GRADIENT", s.reduction, s.edge, s.support);
}

reduction::Frame hough_circles(const strobe::digitize::Photograph& photograph,
                               const strobe::digitize::DigitizeSettings& ball,
                               const HoughSettings& settings) {
  cv::Mat small;
  cv::resize(photograph.intensity, small, {}, 1.0 / settings.reduction, 1.0 / settings.reduction,
             cv::INTER_AREA);
  cv::Mat picture = eight_bits(small);
  cv::GaussianBlur(picture, picture, {}, 1.0);
  const double radius = 0.5 * ball.px_per_m.value() * ball.ball_diameter_m / settings.reduction;
  std::vector<cv::Vec3f> circles;
  cv::HoughCircles(picture, circles, settings.alternative ? cv::HOUGH_GRADIENT_ALT : cv::HOUGH_GRADIENT, 1.5,
                   0.2 * radius, settings.edge, settings.support,
                   static_cast<int>(radius * (1.0 - ball.size_tolerance)),
                   static_cast<int>(radius * (1.0 + ball.size_tolerance)) + 1);
  reduction::Frame frame;
  for (const cv::Vec3f& circle : circles) {
    // Pixel centres are at integers on either picture.
    const double shift = 0.5 * (settings.reduction - 1);
    const cv::Point2d at = cv::Point2d(circle[0], circle[1]) * settings.reduction + cv::Point2d(shift, shift);
    const cv::Point2d centre = ball.map.to_plane(at);
    reduction::BallImage image;
    image.centre_px = {centre.x, centre.y};
    image.diameter_px = 2.0 * static_cast<double>(circle[2]) * settings.reduction;
    frame.images.push_back(image);
  }
  return frame;
}

}  // namespace strobe::studies::digitize
