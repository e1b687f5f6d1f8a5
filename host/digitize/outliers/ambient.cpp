#include "host/digitize/outliers/ambient.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {
namespace {

struct Mean {
  double sum = 0.0, weight = 0.0;
  void add(double value, double by = 1.0) { sum += by * value, weight += by; }
  double value() const { return sum / weight; }
};

// Of fewer numbers a mean or a median says nothing of how they scatter.
constexpr std::size_t kMinOfMean = 3;

// Places across the path, in the ball's radii: where it is, but for the blurred limb, and beside it.
constexpr double kBandEdge = 0.95, kSideFrom = 1.1, kSideTo = 1.6;

/// Light of one image over what is beside it, of each line along its path: of its pixels there, in the share
/// of a diameter that it covers. A ball that moves on under steady light draws a band of just that profile.
class FlashProfile {
 public:
  void add(double across, double light) {
    lines_[line(across)].add(light * std::sqrt(1.0 - across * across));
  }
  /// Over all its breadth it is known, and brighter than what is beside it.
  bool bright() const {
    return std::ranges::all_of(lines_, [](const Mean& mean) { return mean.weight > 0.0 && mean.sum > 0.0; });
  }
  double at(double across) const { return lines_[line(across)].value(); }

 private:
  static constexpr std::size_t kLines = 10;  // from the middle to the edge

  static std::size_t line(double across) {
    const double of_edge = std::abs(across) / kBandEdge;
    return std::min(kLines - 1, static_cast<std::size_t>(of_edge * static_cast<double>(kLines)));
  }
  std::array<Mean, kLines> lines_;
};

/// Across the path, at one place of it.
struct Section {
  cv::Point2d middle, across;
  double radius = 0.0;  ///< of the ball there
  double step = 0.0;    ///< radii from sample to sample
  cv::Point2d at(double s) const { return middle + s * radius * across; }
};

struct Beside {
  double left = 0.0, right = 0.0;  ///< light
  double mean() const { return 0.5 * (left + right); }
  double brighter() const { return std::max(left, right); }
  double apart() const { return std::abs(left - right); }
};

class Bands {
 public:
  Bands(const Photograph& photograph, std::span<const ImageDisc> discs)
      : photograph_(photograph), discs_(discs) {}

  /// Before what follows of a flight between these: of many images only those that lie on its samples count.
  void look_between(const ImageDisc& from, const ImageDisc& to) {
    const cv::Point2d middle = 0.5 * (from.centre + to.centre);
    // A section reaches kSideTo radii aside, up to one beyond an image's middle.
    const double reach =
        0.5 * cv::norm(to.centre - from.centre) + std::hypot(1.0, kSideTo) * std::max(from.radius, to.radius);
    near_.clear();
    for (const ImageDisc& disc : discs_)
      if (cv::norm(disc.centre - middle) < reach + disc.radius + limb_px(disc)) near_.push_back(&disc);
  }

  void learn(const ImageDisc& disc, cv::Point2d along) {
    const double step_px = step_px_of(disc);
    for (double t = -disc.radius; t <= disc.radius; t += step_px) {
      const Section section{disc.centre + t * along, {-along.y, along.x}, disc.radius, step_px / disc.radius};
      const auto sides = beside(section);
      if (!sides) continue;
      const double half = kBandEdge * std::sqrt(std::max(0.0, 1.0 - t * t / (disc.radius * disc.radius)));
      for (double s = -half; s <= half; s += section.step)
        if (const auto light = value(section.at(s), &disc)) flash_.add(s, *light - sides->mean());
    }
  }

  bool knows_flash() const { return flash_.bright(); }

  /// Of a flash's light, median along the way; absent where too little of it is seen.
  std::optional<double> share_between(const ImageDisc& from, const ImageDisc& to) const {
    const cv::Point2d way = to.centre - from.centre;
    const double length = cv::norm(way), step_px = step_px_of(from);
    const cv::Point2d along = way / length, across(-along.y, along.x);
    std::vector<double> shares;
    for (double t = 0.0; t < length; t += step_px) {
      const double radius = from.radius + (to.radius - from.radius) * t / length;
      if (const auto share = share_of({from.centre + t * along, across, radius, step_px / radius}))
        shares.push_back(*share);
    }
    if (shares.size() < kMinOfMean) return std::nullopt;
    return median(std::move(shares));
  }

 private:
  static double step_px_of(const ImageDisc& disc) { return std::max(1.0, disc.radius / 20.0); }

  /// What the lens spreads most of a limb.
  static double limb_px(const ImageDisc& disc) { return kDoubtful_sd * disc.blur_px; }

  /// The factor by which the flash's profile fits best.
  std::optional<double> share_of(const Section& section) const {
    constexpr double kMinSeen = 0.1;   // of the squares of the whole profile
    constexpr double kMaxApart = 0.5;  // of a flash: a wall's edge between hides any band that is told of
    const auto sides = beside(section);
    if (!sides || sides->apart() > kMaxApart * flash_.at(0.0)) return std::nullopt;
    double whole = 0.0, seen = 0.0, product = 0.0;
    for (double s = -kBandEdge; s <= kBandEdge; s += section.step) {
      const double flash = flash_.at(s);
      whole += flash * flash;
      const auto light = value(section.at(s), nullptr);
      if (!light) continue;
      seen += flash * flash;
      product += flash * (*light - sides->brighter());
    }
    if (!(seen > kMinSeen * whole)) return std::nullopt;
    return product / seen;
  }

  std::optional<Beside> beside(const Section& section) const {
    std::array<Mean, 2> sides;
    for (double s = kSideFrom; s <= kSideTo; s += section.step) {
      if (const auto light = value(section.at(s), nullptr)) sides[0].add(*light);
      if (const auto light = value(section.at(-s), nullptr)) sides[1].add(*light);
    }
    if (std::min(sides[0].weight, sides[1].weight) < static_cast<double>(kMinOfMean)) return std::nullopt;
    return Beside{sides[0].value(), sides[1].value()};
  }

  /// Where no image but `own` is.
  std::optional<double> value(cv::Point2d at, const ImageDisc* own) const {
    const int column = cvRound(at.x), row = cvRound(at.y);
    if (column < 0 || row < 0 || column >= photograph_.width() || row >= photograph_.height())
      return std::nullopt;
    for (const ImageDisc* disc : near_)
      if (disc != own && cv::norm(at - disc->centre) < disc->radius + limb_px(*disc)) return std::nullopt;
    return static_cast<double>(photograph_.intensity.at<float>(row, column));
  }

  const Photograph& photograph_;
  std::span<const ImageDisc> discs_;
  std::vector<const ImageDisc*> near_;
  FlashProfile flash_;
};

}  // namespace

ImageDisc image_disc(const PlaneMap& map, const Outline& outline) {
  const cv::Point2d centre = map.to_image(outline.centre);
  const double scale = map.image_px_per_plane_px(centre);
  return {.centre = centre, .radius = 0.5 * outline.diameter * scale, .blur_px = outline.blur_px * scale};
}

std::optional<double> ambient_share(const Photograph& photograph, std::span<const ImageDisc> discs,
                                    std::span<const Flight> flights) {
  Bands bands(photograph, discs);
  for (const Flight& flight : flights) {
    const cv::Point2d way = discs[flight.to].centre - discs[flight.from].centre;
    bands.look_between(discs[flight.from], discs[flight.to]);
    bands.learn(discs[flight.from], way / cv::norm(way));
    bands.learn(discs[flight.to], way / cv::norm(way));
  }
  if (!bands.knows_flash()) return std::nullopt;
  std::vector<double> shares;
  for (const Flight& flight : flights) {
    bands.look_between(discs[flight.from], discs[flight.to]);
    if (const auto share = bands.share_between(discs[flight.from], discs[flight.to]))
      shares.push_back(*share);
  }
  if (shares.size() < kMinOfMean) return std::nullopt;
  // Of an even number the lower of the middle ones.
  std::ranges::sort(shares);
  return std::max(0.0, shares[(shares.size() - 1) / 2]);
}

}  // namespace strobe::digitize
