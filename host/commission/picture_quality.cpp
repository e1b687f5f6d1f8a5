#include "host/commission/picture_quality.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "host/commission/statistics.hpp"
#include "host/digitize/core/statistics.hpp"

namespace strobe::commission {
namespace {

using digitize::Outline;
using digitize::Photograph;

/// In image px.
struct Disc {
  cv::Point2d centre;
  double radius = 0.0;
};

Disc disc_of(const digitize::PlaneMap& map, const Outline& outline) {
  const cv::Point2d centre = map.to_image(outline.centre);
  const cv::Point2d edge = map.to_image(outline.centre + cv::Point2d(0.5 * outline.diameter, 0.0));
  return {centre, cv::norm(edge - centre)};
}

/// The pixels well inside.
std::vector<float> pixels_of(const Photograph& photograph, const Disc& disc) {
  constexpr double kInside = 0.95;
  std::vector<float> values;
  const double r = kInside * disc.radius;
  const int first = std::max(0, static_cast<int>(disc.centre.y - r));
  const int last = std::min(photograph.height() - 1, static_cast<int>(disc.centre.y + r));
  for (int row = first; row <= last; ++row) {
    const double half = std::sqrt(std::max(0.0, r * r - (row - disc.centre.y) * (row - disc.centre.y)));
    const int from = std::max(0, static_cast<int>(disc.centre.x - half));
    const int to = std::min(photograph.width() - 1, static_cast<int>(disc.centre.x + half));
    const float* line = photograph.intensity.ptr<float>(row);
    values.insert(values.end(), line + std::min(from, to), line + std::max(from, to));
  }
  return values;
}

double dark_of(const Photograph& photograph) {
  constexpr int kEvery = 7;  // of rows and columns
  std::vector<float> values;
  for (int row = 0; row < photograph.height(); row += kEvery) {
    const float* line = photograph.intensity.ptr<float>(row);
    for (int column = 0; column < photograph.width(); column += kEvery) values.push_back(line[column]);
  }
  return static_cast<double>(digitize::quantile(std::move(values), 1, 100));
}

/// Over the pictures with a ball. A normal's median is 1.25 times as uncertain as its mean.
struct Median {
  double value = 0.0, margin = 0.0;
  Interval range() const { return {value - margin, value + margin}; }
};

Median median_of(std::span<const PictureQuality> pictures, double PictureQuality::*value) {
  std::vector<double> values;
  Sample sample;
  for (const PictureQuality& p : pictures) {
    if (p.images == 0) continue;
    values.push_back(p.*value);
    sample.add(p.*value);
  }
  return {digitize::median(std::move(values)), 1.2533 * sample.mean_margin()};
}

StepResult no_images() {
  return failed("no_images", "no ball is seen on any photograph",
                "look at a photograph: is the ball on it, at the size that the rig file's scale says?");
}

int images_of(std::span<const PictureQuality> pictures) {
  int images = 0;
  for (const PictureQuality& p : pictures) images += p.images;
  return images;
}

}  // namespace

PictureQuality picture_quality(const Photograph& photograph, const digitize::PlaneMap& map,
                               const digitize::Digitization& found) {
  PictureQuality quality;
  quality.images = static_cast<int>(found.outlines.size());
  quality.transfer = found.transfer;
  quality.dark = dark_of(photograph) / static_cast<double>(photograph.saturation);
  std::vector<double> blurs, bright;
  std::size_t saturated = 0, pixels = 0;
  for (const Outline& outline : found.outlines) {
    blurs.push_back(outline.blur_px);
    const Disc disc = disc_of(map, outline);
    const std::vector<float> values = pixels_of(photograph, disc);
    pixels += values.size();
    saturated += static_cast<std::size_t>(
        std::ranges::count_if(values, [&](float v) { return v >= photograph.saturation; }));
    if (!values.empty())
      bright.push_back(static_cast<double>(digitize::quantile(values, 9, 10) / photograph.saturation));
  }
  quality.blur_px = digitize::median(std::move(blurs));
  quality.brightness = digitize::median(std::move(bright));
  if (pixels > 0) quality.saturated_share = static_cast<double>(saturated) / static_cast<double>(pixels);
  return quality;
}

StepResult judge_focus(std::span<const PictureQuality> pictures) {
  if (images_of(pictures) == 0) return no_images();
  const Median blur = median_of(pictures, &PictureQuality::blur_px);
  StepResult result = passed(blur.value, {}, "px", fmt::format("at most {:.1f} px", kMaxBlur_px));
  result.words = fmt::format("edges of balls are blurred by {:.2f} px", blur.value);
  result.figures = {{"blur_px", blur.value, {}, {}, images_of(pictures)}};
  hold(result, blur.range(), {.most = kMaxBlur_px}, "out_of_focus",
       "focus on the plane in which balls fly, tape the lens, and stop it down to f/5.6 or f/8");
  return result;
}

StepResult judge_exposure(std::span<const PictureQuality> pictures) {
  if (images_of(pictures) == 0) return no_images();
  const Median saturated = median_of(pictures, &PictureQuality::saturated_share);
  const Median bright = median_of(pictures, &PictureQuality::brightness);
  const Median dark = median_of(pictures, &PictureQuality::dark);
  StepResult result =
      passed(100.0 * saturated.value, {}, "%",
             fmt::format("at most {:.0f} % of the balls' pixels saturated, balls brighter than {:.0f} % of "
                         "white, dark below {:.0f} %",
                         100.0 * kMaxSaturatedShare, 100.0 * kMinBrightness, 100.0 * kMaxDark));
  result.words = fmt::format(
      "{:.1f} % of the balls' pixels saturate, balls are at {:.0f} % of white, the dark at {:.1f} %",
      100.0 * saturated.value, 100.0 * bright.value, 100.0 * dark.value);
  result.figures = {{"saturated_percent", 100.0 * saturated.value, {}, {}, images_of(pictures)},
                    {"brightness_percent", 100.0 * bright.value, {}, {}, images_of(pictures)},
                    {"dark_percent", 100.0 * dark.value, {}, {}, static_cast<int>(pictures.size())}};
  hold(result, saturated.range(), {.most = kMaxSaturatedShare}, "overexposed",
       "lower the ISO or close the aperture: no pixel of one image may be white");
  hold(result, bright.range(), {.least = kMinBrightness}, "underexposed",
       "raise the ISO or bring the lamps nearer");
  hold(result, dark.range(), {.most = kMaxDark}, "not_dark",
       "darken the room, or take away what reflects the lamps behind the balls");
  return result;
}

StepResult judge_transfer(std::span<const PictureQuality> pictures) {
  double sum = 0.0, weights = 0.0;
  int crossings = 0, told = 0;
  for (const PictureQuality& p : pictures) {
    if (!p.transfer) continue;
    const double sd = std::max(p.transfer->sd, 0.005);
    sum += p.transfer->exponent / (sd * sd);
    weights += 1.0 / (sd * sd);
    crossings += p.transfer->crossings;
    ++told;
  }
  if (told == 0)
    return skipped(
        "images of balls overlap too little to tell whether the file's numbers are proportional to light",
        "choose a shorter period for once, so that images overlap");
  // Of light: 0.85 widens a ball by about its diameter's usual sd (TransferCurve::is_proportional()).
  constexpr double kExponentTolerance = 0.15;
  digitize::TransferCurve pooled{sum / weights, 1.0 / std::sqrt(weights), crossings};
  StepResult result =
      passed(pooled.exponent, pooled.sd, "", fmt::format("1 within {:.2f}", kExponentTolerance));
  result.figures = {{"exponent", pooled.exponent, pooled.sd, 1.0, crossings}};
  result.words = fmt::format("the file's numbers are light to the power of {:.2f} ± {:.2f}, by {} overlaps",
                             pooled.exponent, pooled.sd, crossings);
  hold(result, interval(pooled.exponent, pooled.sd), within(kExponentTolerance, 1.0), "not_proportional",
       "convert RAW files with a linear curve (firmware/BENCH.md, section 4); until then the digitizer "
       "undoes the curve");
  return result;
}

}  // namespace strobe::commission
