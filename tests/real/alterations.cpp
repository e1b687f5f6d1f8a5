#include "tests/real/alterations.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "common/image/image_files.hpp"
#include "common/image/opencv.hpp"

namespace strobe::real {

namespace {

double full_of(const cv::Mat& pixels) { return pixels.depth() == CV_16U ? 65535.0 : 255.0; }

/// Numbers in units of 1/255 of the largest, changed, rounded back.
template <typename Change>
Altered with_light(const cv::Mat& pixels, Change change) {
  const double unit = full_of(pixels) / 255.0;
  cv::Mat light;
  pixels.convertTo(light, CV_32F, 1.0 / unit);
  change(light);
  Altered altered;
  light.convertTo(altered.pixels, pixels.depth(), unit);
  return altered;
}

Altered as_it_is(const cv::Mat& pixels) { return {pixels.clone()}; }

Altered mirrored(const cv::Mat& pixels) {
  Altered altered{{}, {-1.0, 0.0, pixels.cols - 1.0, 0.0, 1.0, 0.0}};
  cv::flip(pixels, altered.pixels, 1);
  return altered;
}

Altered upside_down(const cv::Mat& pixels) {
  Altered altered{{}, {1.0, 0.0, 0.0, 0.0, -1.0, pixels.rows - 1.0}};
  cv::flip(pixels, altered.pixels, 0);
  return altered;
}

template <int percent>
Altered scaled(const cv::Mat& pixels) {
  const double scale = 0.01 * percent;
  const cv::Size size(cvRound(pixels.cols * scale), cvRound(pixels.rows * scale));
  Altered altered;
  // Areas, not samples, where pixels become fewer: nothing aliases.
  cv::resize(pixels, altered.pixels, size, 0.0, 0.0, percent < 100 ? cv::INTER_AREA : cv::INTER_CUBIC);
  const double fx = static_cast<double>(size.width) / pixels.cols;
  const double fy = static_cast<double>(size.height) / pixels.rows;
  altered.move = {fx, 0.0, 0.5 * fx - 0.5, 0.0, fy, 0.5 * fy - 0.5};
  altered.scale = std::sqrt(fx * fy);
  return altered;
}

Altered jpeg(const cv::Mat& pixels) {
  cv::Mat bytes;
  pixels.convertTo(bytes, CV_8U, 255.0 / full_of(pixels));
  const auto file = image::encode_jpeg(image::pixels_of(bytes), 70);
  auto raster = file ? image::decode_jpeg(*file) : tl::unexpected(file.error());
  if (!raster) throw std::runtime_error(raster.error().message);
  Altered altered;
  image::mat_of(*raster).convertTo(altered.pixels, pixels.depth(), full_of(pixels) / 255.0);
  return altered;
}

Altered dark(const cv::Mat& pixels) {
  return with_light(pixels, [](cv::Mat& light) { light *= 0.6; });
}

Altered noisy(const cv::Mat& pixels) {
  return with_light(pixels, [](cv::Mat& light) {
    cv::Mat noise(light.size(), light.type());
    cv::RNG(7).fill(noise, cv::RNG::NORMAL, 0.0, 4.0);
    light += noise;
  });
}

Altered blurred(const cv::Mat& pixels) {
  return with_light(pixels, [](cv::Mat& light) { cv::GaussianBlur(light, light, {}, 1.2); });
}

Altered turned(const cv::Mat& pixels) {
  const cv::Mat turn = cv::getRotationMatrix2D(
      cv::Point2f(0.5F * static_cast<float>(pixels.cols - 1), 0.5F * static_cast<float>(pixels.rows - 1)),
      3.0, 1.0);
  Altered altered;
  cv::warpAffine(pixels, altered.pixels, turn, pixels.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  std::copy(turn.begin<double>(), turn.end<double>(), altered.move.begin());
  return altered;
}

Altered gamma(const cv::Mat& pixels) {
  return with_light(pixels, [](cv::Mat& light) {
    cv::pow(light / 255.0, 0.7, light);
    light *= 255.0;
  });
}

/// By an odd number of pixels, so that no grid of blocks or tiles stays where it was.
Altered cropped(const cv::Mat& pixels) {
  constexpr int left = 11, top = 7, right = 3, bottom = 5;
  const cv::Rect kept(left, top, pixels.cols - left - right, pixels.rows - top - bottom);
  return {pixels(kept).clone(), {1.0, 0.0, -left, 0.0, 1.0, -top}};
}

Altered with_hot_pixels(const cv::Mat& pixels) {
  constexpr int one_in = 5000;
  Altered altered{pixels.clone()};
  cv::RNG drawn(5);
  for (int left = pixels.rows * pixels.cols / one_in; left > 0; --left) {
    const int y = drawn.uniform(0, pixels.rows), x = drawn.uniform(0, pixels.cols);
    altered.pixels(cv::Rect(x, y, 1, 1)).setTo(cv::Scalar::all(full_of(pixels)));
  }
  return altered;
}

Altered with_colours_exchanged(const cv::Mat& pixels) {
  Altered altered{pixels.clone()};
  if (pixels.channels() == 3) cv::cvtColor(pixels, altered.pixels, cv::COLOR_BGR2RGB);
  return altered;
}

/// How far a circle reaches over the border, 0 if it does not, in its diameters.
double beyond_border(const Circle& circle, cv::Size size) {
  const double r = 0.5 * circle.d;
  return std::max({0.0, r - 0.5 - circle.x, r - 0.5 - circle.y, circle.x + r - size.width + 0.5,
                   circle.y + r - size.height + 0.5}) /
         circle.d;
}

}  // namespace

Point moved(Point point, const Move& move) {
  return {move[0] * point.x + move[1] * point.y + move[2], move[3] * point.x + move[4] * point.y + move[5]};
}

const std::vector<Alteration>& alterations() {
  static const std::vector<Alteration> all{
      {"as-is", "nothing is done", as_it_is},
      {"mirrored", "left and right exchanged", mirrored},
      {"upside-down", "top and bottom exchanged", upside_down, false},
      {"x0.8", "made smaller", scaled<80>},
      {"x1.25", "made larger", scaled<125>},
      {"x0.99", "made a little smaller", scaled<99>},
      {"x1.01", "made a little larger", scaled<101>},
      {"jpeg-70", "compressed as a JPEG of quality 70", jpeg},
      {"dark", "0.6 of the light", dark},
      {"noise-4", "noise with an sd of 4 of 255", noisy},
      {"blur-1.2", "blurred with an sd of 1.2 px", blurred},
      {"turned-3", "turned by 3 degrees about its middle", turned},
      {"gamma-0.7", "each number to the power of 0.7", gamma},
      {"cropped", "3 to 11 px less at each side", cropped},
      {"hot-pixels", "one pixel in 5000 full", with_hot_pixels},
      {"colours", "red and blue exchanged", with_colours_exchanged},
  };
  return all;
}

Photograph altered_truth(const Photograph& photograph, const Altered& altered, cv::Size before) {
  Photograph truth = photograph;
  truth.px_per_m *= altered.scale;
  for (Ball& ball : truth.balls) {
    const double was_beyond = beyond_border(ball, before);
    const Point to = moved({ball.x, ball.y}, altered.move);
    ball.x = to.x, ball.y = to.y, ball.d *= altered.scale;
    // What the border cuts already must be found unless a good part more of it is cut.
    constexpr double kCut = 0.25;
    const double cut = beyond_border(ball, altered.pixels.size()) - was_beyond;
    if (ball.kind == Kind::ball && cut > (was_beyond > 0.0 ? kCut : 0.0)) ball.kind = Kind::optional;
  }
  for (Point& corner : truth.ghost_path) corner = moved(corner, altered.move);
  return truth;
}

}  // namespace strobe::real
