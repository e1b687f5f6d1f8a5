#include "host/light/measures.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/reduction/frame.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/outliers/ambient.hpp"
#include "host/light/limb_sectors.hpp"

namespace strobe::light {
namespace {

using digitize::Digitization;
using digitize::Flight;
using digitize::ImageDisc;
using digitize::Outline;
using digitize::Photograph;
using digitize::PlaneMap;
using reduction::Leg;

std::vector<ImageDisc> discs_of(const PlaneMap& map, const Digitization& found) {
  std::vector<ImageDisc> discs;
  for (std::size_t i = 0; i < found.outlines.size(); ++i) {
    discs.push_back(image_disc(map, found.outlines[i]));
    discs.back().airborne = i >= found.frame.images.size() || found.frame.images[i].leg != Leg::contact;
  }
  return discs;
}

/// Of each leg's images, one after the other.
std::vector<Flight> flights_of(const Digitization& found) {
  std::vector<Flight> flights;
  const auto leg = [&](std::size_t i) { return found.frame.images[i].leg; };
  for (std::size_t i = 1; i < found.outlines.size() && i < found.frame.images.size(); ++i)
    if (leg(i) == leg(i - 1) && leg(i) != Leg::contact) flights.push_back({i - 1, i});
  return flights;
}

/// The pixels of one ball that no other image covers.
struct OwnPixels {
  std::vector<float> values;
  std::size_t clipped_left = 0, clipped_right = 0, left = 0, right = 0;
};

class OwnPixelsOf {
 public:
  OwnPixelsOf(const Photograph& photograph, const std::vector<ImageDisc>& discs, std::size_t index)
      : photograph_(photograph), disc_(discs[index]) {
    for (std::size_t j = 0; j < discs.size(); ++j)
      if (j != index &&
          cv::norm(discs[j].centre - disc_.centre) < discs[j].radius + disc_.radius + kBeside_px)
        near_.push_back(discs[j]);
  }

  OwnPixels take() {
    constexpr double kInside = 0.95;
    constexpr int kRows = 2;  // one of so many
    const int reach = static_cast<int>(kInside * disc_.radius);
    const int column = cvRound(disc_.centre.x), row = cvRound(disc_.centre.y);
    for (int dy = -reach; dy <= reach; dy += kRows) {
      const int half = static_cast<int>(std::sqrt(static_cast<double>(reach * reach - dy * dy)));
      for (int dx = 1; dx <= half; ++dx) {
        add(column + dx, row + dy, own_.right, own_.clipped_right);
        add(column - dx, row + dy, own_.left, own_.clipped_left);
      }
    }
    return std::move(own_);
  }

 private:
  static constexpr double kBeside_px = 4.0;

  void add(int column, int row, std::size_t& pixels, std::size_t& clipped) {
    if (column < 0 || row < 0 || column >= photograph_.width() || row >= photograph_.height()) return;
    const cv::Point2d at(column, row);
    for (const ImageDisc& other : near_)
      if (cv::norm(at - other.centre) < other.radius + kBeside_px) return;
    const float value = photograph_.intensity.at<float>(row, column);
    own_.values.push_back(value);
    ++pixels;
    clipped += value >= photograph_.saturation ? 1 : 0;
  }

  const Photograph& photograph_;
  ImageDisc disc_;
  std::vector<ImageDisc> near_;
  OwnPixels own_;
};

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

void measure_whole(const Photograph& photograph, LightMeasures& measures) {
  constexpr int kEvery = 7;  // of rows and columns
  std::vector<float> values;
  for (int row = 0; row < photograph.height(); row += kEvery) {
    const float* line = photograph.intensity.ptr<float>(row);
    for (int column = 0; column < photograph.width(); column += kEvery) values.push_back(line[column]);
  }
  const auto white = static_cast<double>(photograph.saturation);
  measures.dark = static_cast<double>(digitize::quantile(values, 1, 100)) / white;
  measures.bright = static_cast<double>(digitize::quantile(std::move(values), 999, 1000)) / white;
}

/// The least of positive values over what a line through the logarithms of all says of its place (Theil and
/// Sen): lamps and lens light the middle of the picture more than its sides.
double weakest_of(const std::vector<double>& x, const std::vector<double>& light) {
  constexpr std::size_t kMinImages = 5;
  if (light.size() < kMinImages) return 1.0;
  std::vector<double> logs, slopes, rests;
  for (const double each : light) logs.push_back(std::log(std::max(each, 1e-6)));
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (x[i] != x[j]) slopes.push_back((logs[i] - logs[j]) / (x[i] - x[j]));
  const double slope = digitize::median(std::move(slopes));
  for (std::size_t i = 0; i < x.size(); ++i) rests.push_back(logs[i] - slope * x[i]);
  const double least = *std::ranges::min_element(rests);
  return std::exp(least - digitize::median(std::move(rests)));
}

/// The background's light is in the measures.
void measure_balls(const Photograph& photograph, const std::vector<ImageDisc>& discs,
                   LightMeasures& measures) {
  constexpr double kMinShare = 0.25;  // of a disc
  const bool any_airborne = std::ranges::any_of(discs, &ImageDisc::airborne);
  const auto white = static_cast<double>(photograph.saturation);
  std::vector<double> felt, at;
  std::size_t left = 0, right = 0, clipped_left = 0, clipped_right = 0;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    if (any_airborne && !discs[i].airborne) continue;
    OwnPixels own = OwnPixelsOf(photograph, discs, i).take();
    left += own.left, right += own.right;
    clipped_left += own.clipped_left, clipped_right += own.clipped_right;
    const double area = std::numbers::pi * discs[i].radius * discs[i].radius;
    if (2.0 * static_cast<double>(own.values.size()) < kMinShare * area) continue;
    at.push_back(discs[i].centre.x);
    felt.push_back(static_cast<double>(digitize::quantile(std::move(own.values), 9, 10)) / white -
                   measures.background);
  }
  measures.clipped_share = share(clipped_left + clipped_right, left + right);
  measures.clipped = {share(clipped_left, left), share(clipped_right, right)};
  measures.weakest = weakest_of(at, felt);
  measures.felt = digitize::median(std::move(felt));
}

/// The sd of a pixel's noise beside the balls: from second differences along rows, which a smooth background
/// leaves alone; a file's steps add to it.
double noise_beside(const Photograph& photograph, const std::vector<ImageDisc>& discs) {
  constexpr double kNear_px = 6.0, kFar_px = 30.0;
  const double kRoot6 = std::sqrt(6.0);  // of the sum of the squares of 1, -2, 1
  std::vector<double> differences;
  for (const ImageDisc& disc : discs) {
    const double reach = disc.radius + kFar_px;
    for (int row = static_cast<int>(disc.centre.y - reach); row <= static_cast<int>(disc.centre.y + reach);
         row += 6) {
      if (row < 0 || row >= photograph.height()) continue;
      const float* line = photograph.intensity.ptr<float>(row);
      for (int column = std::max(1, static_cast<int>(disc.centre.x - reach));
           column <= std::min(photograph.width() - 2, static_cast<int>(disc.centre.x + reach)); column += 4) {
        const bool beside = std::ranges::all_of(discs, [&](const ImageDisc& d) {
          return cv::norm(cv::Point2d(column, row) - d.centre) > d.radius + kNear_px;
        });
        if (!beside) continue;
        differences.push_back(
            std::abs(static_cast<double>(line[column - 1] - 2 * line[column] + line[column + 1])));
      }
    }
  }
  const double sd = digitize::kSdOverMad * digitize::median(std::move(differences)) / kRoot6;
  return std::max(sd, photograph.rounding_sd()) / static_cast<double>(photograph.saturation);
}

/// Directions of flight, from an image's neighbours on its leg; absent where there are none.
std::vector<std::optional<double>> directions_rad(const Digitization& found) {
  std::vector<std::optional<double>> directions(found.outlines.size());
  const auto leg = [&](std::size_t i) { return found.frame.images[i].leg; };
  for (std::size_t i = 0; i < directions.size() && i < found.frame.images.size(); ++i) {
    if (leg(i) == Leg::contact) continue;
    std::size_t from = i, to = i;
    if (i > 0 && leg(i - 1) == leg(i)) from = i - 1;
    if (i + 1 < found.frame.images.size() && leg(i + 1) == leg(i)) to = i + 1;
    const cv::Point2d way = found.outlines[to].centre - found.outlines[from].centre;
    if (from != to) directions[i] = std::atan2(way.y, way.x);
  }
  return directions;
}

struct Median {
  double value = 0.0, sd = 0.0;
};

Median median_of(const std::vector<double>& values) {
  Median median{digitize::median(values), 0.0};
  std::vector<double> off;
  for (const double v : values) off.push_back(std::abs(v - median.value));
  // A normal's median is 1.25 times as uncertain as its mean.
  median.sd = 1.2533 * digitize::kSdOverMad * digitize::median(std::move(off)) /
              std::sqrt(static_cast<double>(std::max<std::size_t>(values.size(), 1)));
  return median;
}

/// A ball that moves by w in a flash adds w²/12 to the variance of its limb's blur along the path.
void measure_smear(const Digitization& found, const std::vector<LimbSector>& sectors,
                   LightMeasures& measures) {
  constexpr double kAlong = 0.85, kAcross = 0.5;  // |cosine| of the limb's normal to the path
  constexpr std::size_t kMinSectors = 6;
  constexpr double kMaxBlurSd = 0.3;  // over the blur
  constexpr double kSds = 2.33;       // 99 % on one side
  const auto directions = directions_rad(found);
  std::vector<double> along, across, cosines_along, cosines_across;
  for (const LimbSector& sector : sectors) {
    const auto& direction = directions[sector.outline];
    if (!direction || !sector.edge || sector.edge->sd_px > kMaxBlurSd * sector.edge->blur_px) continue;
    const double cosine = std::abs(std::cos(sector.normal_rad - *direction));
    const double square = cosine * cosine, variance = sector.edge->blur_px * sector.edge->blur_px;
    if (cosine > kAlong) along.push_back(variance), cosines_along.push_back(square);
    if (cosine < kAcross) across.push_back(variance), cosines_across.push_back(square);
  }
  if (along.size() < kMinSectors || across.size() < kMinSectors) return;
  const double lever =
      digitize::median(std::move(cosines_along)) - digitize::median(std::move(cosines_across));
  const Median a = median_of(along), b = median_of(across);
  const double excess = (a.value - b.value) / lever, sd = std::hypot(a.sd, b.sd) / lever;
  measures.smear_px = std::sqrt(12.0 * std::max(0.0, excess));
  measures.smear_least_px = std::sqrt(12.0 * std::max(0.0, excess - kSds * sd));
}

void measure_focus(const Digitization& found, LightMeasures& measures) {
  constexpr std::size_t kMinImages = 5;
  std::vector<double> blurs;
  for (const Outline& outline : found.outlines) blurs.push_back(outline.blur_px);
  measures.blur_px = digitize::median(blurs);
  if (blurs.size() < kMinImages) return;
  double mean_x = 0.0, mean_blur = 0.0;
  const auto n = static_cast<double>(blurs.size());
  for (const Outline& o : found.outlines) mean_x += o.centre.x / n, mean_blur += o.blur_px / n;
  double square = 0.0, product = 0.0, least = found.outlines[0].centre.x, most = least;
  for (const Outline& o : found.outlines) {
    square += (o.centre.x - mean_x) * (o.centre.x - mean_x);
    product += (o.centre.x - mean_x) * (o.blur_px - mean_blur);
    least = std::min(least, o.centre.x), most = std::max(most, o.centre.x);
  }
  if (!(square > 0.0)) return;
  const double slope = product / square;
  double residuals = 0.0;
  for (const Outline& o : found.outlines) {
    const double off = o.blur_px - mean_blur - slope * (o.centre.x - mean_x);
    residuals += off * off;
  }
  const double variance = residuals / (n - 2.0);
  measures.blur_at_px = Sides{mean_blur + slope * (least - mean_x), mean_blur + slope * (most - mean_x)};
  measures.blur_at_sd_px =
      std::sqrt(variance * (1.0 / n + std::pow(std::max(mean_x - least, most - mean_x), 2) / square));
}

void measure_limbs(const Photograph& photograph, const std::vector<LimbSector>& sectors,
                   LightMeasures& measures) {
  constexpr double kAside = 0.7;  // cosine of a limb's normal
  constexpr std::size_t kMinSectors = 6;
  const auto white = static_cast<double>(photograph.saturation);
  std::vector<double> rises, outside, black, left, right;
  for (const LimbSector& sector : sectors) {
    const double x = std::cos(sector.normal_rad);
    if (x > kAside) right.push_back(sector.rise / white);
    if (x < -kAside) left.push_back(sector.rise / white);
    if (sector.edge) rises.push_back(sector.rise / white);
    if (!sector.clear) continue;
    outside.push_back(sector.outside / white);
    black.push_back(sector.black_share);
  }
  measures.limb_rise = digitize::median(std::move(rises));
  measures.background = outside.empty() ? measures.dark : digitize::median(std::move(outside));
  measures.black_share = digitize::median(std::move(black));
  if (left.size() >= kMinSectors && right.size() >= kMinSectors)
    measures.limbs = Sides{digitize::median(std::move(left)), digitize::median(std::move(right))};
}

bool is_jpeg(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name.ends_with(".jpg") || name.ends_with(".jpeg");
}

}  // namespace

LightMeasures measure_light(const Photograph& photograph, const PlaneMap& map, const Digitization& found) {
  LightMeasures measures;
  measures.images = static_cast<int>(found.outlines.size());
  measures.bits = photograph.bits;
  measures.jpeg = is_jpeg(photograph.name);
  measures.transfer = found.transfer;
  measure_whole(photograph, measures);
  if (found.outlines.empty()) return measures;
  const std::vector<ImageDisc> discs = discs_of(map, found);
  const std::vector<LimbSector> sectors = limb_sectors(photograph, map, found.outlines);
  measure_limbs(photograph, sectors, measures);
  measure_balls(photograph, discs, measures);
  measures.ambient = ambient_share(photograph, discs, flights_of(found));
  measures.noise = noise_beside(photograph, discs);
  measure_focus(found, measures);
  measure_smear(found, sectors, measures);
  return measures;
}

}  // namespace strobe::light
