#include "host/commission/picture_quality.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

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

template <typename Value>
double median_of(std::span<const PictureQuality> pictures, Value value) {
  std::vector<double> values;
  for (const PictureQuality& p : pictures)
    if (p.images > 0) values.push_back(value(p));
  return digitize::median(std::move(values));
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
  const double blur = median_of(pictures, [](const PictureQuality& p) { return p.blur_px; });
  StepResult result = passed(blur, {}, "px", fmt::format("at most {:.1f} px", kMaxBlur_px));
  result.words = fmt::format("edges of balls are blurred by {:.2f} px", blur);
  result.figures = {{"blur_px", blur, {}, {}, images_of(pictures)}};
  if (blur > kMaxBlur_px)
    mark_failed(result, "out_of_focus",
                "focus on the plane in which balls fly, tape the lens, and stop it down to f/5.6 or f/8");
  return result;
}

StepResult judge_exposure(std::span<const PictureQuality> pictures) {
  if (images_of(pictures) == 0) return no_images();
  const double saturated = median_of(pictures, [](const PictureQuality& p) { return p.saturated_share; });
  const double bright = median_of(pictures, [](const PictureQuality& p) { return p.brightness; });
  const double dark = median_of(pictures, [](const PictureQuality& p) { return p.dark; });
  StepResult result =
      passed(100.0 * saturated, {}, "%",
             fmt::format("at most {:.0f} % of the balls' pixels saturated, balls brighter than {:.0f} % of "
                         "white, dark below {:.0f} %",
                         100.0 * kMaxSaturatedShare, 100.0 * kMinBrightness, 100.0 * kMaxDark));
  result.words = fmt::format(
      "{:.1f} % of the balls' pixels saturate, balls are at {:.0f} % of white, the dark at {:.1f} %",
      100.0 * saturated, 100.0 * bright, 100.0 * dark);
  result.figures = {{"saturated_percent", 100.0 * saturated, {}, {}, images_of(pictures)},
                    {"brightness_percent", 100.0 * bright, {}, {}, images_of(pictures)},
                    {"dark_percent", 100.0 * dark, {}, {}, static_cast<int>(pictures.size())}};
  if (saturated > kMaxSaturatedShare)
    mark_failed(result, "overexposed",
                "lower the ISO or close the aperture: no pixel of one image may be white");
  else if (bright < kMinBrightness)
    mark_failed(result, "underexposed", "raise the ISO or bring the lamps nearer");
  else if (dark > kMaxDark)
    mark_failed(result, "not_dark", "darken the room, or take away what reflects the lamps behind the balls");
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
  digitize::TransferCurve pooled{sum / weights, 1.0 / std::sqrt(weights), crossings};
  StepResult result = passed(pooled.exponent, pooled.sd, "", "1 within 0.15, or within 4 sd");
  result.figures = {{"exponent", pooled.exponent, pooled.sd, 1.0, crossings}};
  result.words = fmt::format("the file's numbers are light to the power of {:.2f} ± {:.2f}, by {} overlaps",
                             pooled.exponent, pooled.sd, crossings);
  if (!pooled.is_proportional())
    mark_failed(result, "not_proportional",
                "convert RAW files with a linear curve (bench, section 4); until then the digitizer undoes "
                "the curve");
  return result;
}

}  // namespace strobe::commission
