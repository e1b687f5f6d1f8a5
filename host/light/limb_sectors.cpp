#include "host/light/limb_sectors.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "host/digitize/outline/edge_profile.hpp"

namespace strobe::light {
namespace {

using digitize::Outline;
using digitize::Photograph;
using digitize::PlaneMap;

constexpr double kSector_px = 16.0;
constexpr double kBin_px = 0.5;
/// Beyond three sd of the blur, as the digitizer fits it.
constexpr double kOutside_px = 4.0, kInside_px = 6.0;

/// The mean light at one depth.
struct Bin {
  double depth_px = 0.0, light = 0.0;
  int pixels = 0;
};

struct Profile {
  std::vector<Bin> bins;
  int outside = 0, black = 0;  ///< pixels
  bool crossed = false;        ///< by another image's limb or the border
  bool clear = true;           ///< of other images
  bool seen = false;           ///< by the digitizer
};

double full_turn(double angle_rad) {
  return angle_rad < 0.0 ? angle_rad + 2.0 * std::numbers::pi : angle_rad;
}

bool seen(const Outline& outline, double from_rad, double to_rad) {
  return std::ranges::any_of(outline.visible_arcs, [&](const digitize::Arc& arc) {
    const double begin = full_turn(std::remainder(from_rad - arc.from_rad, 2.0 * std::numbers::pi));
    return begin + (to_rad - from_rad) <= arc.extent_rad + 1e-9;
  });
}

class Ring {
 public:
  Ring(const Photograph& photograph, const PlaneMap& map, std::span<const Outline> outlines,
       std::size_t index)
      : photograph_(photograph), map_(map), outlines_(outlines), outline_(outlines[index]) {
    radius_ = 0.5 * outline_.diameter;
    outside_ = 3.0 * outline_.blur_px + kOutside_px;
    inside_ = std::min(3.0 * outline_.blur_px + kInside_px, 0.5 * radius_);
    const double turn = 2.0 * std::numbers::pi;
    count_ = std::max(8, static_cast<int>(turn * radius_ / kSector_px));
    profiles_.resize(static_cast<std::size_t>(count_));
    const auto bins = static_cast<std::size_t>((outside_ + inside_) / kBin_px) + 1;
    for (int k = 0; k < count_; ++k) {
      Profile& profile = profiles_[static_cast<std::size_t>(k)];
      profile.bins.resize(bins);
      profile.seen = seen(outline_, k * turn / count_, (k + 1) * turn / count_);
    }
    for (std::size_t j = 0; j < outlines.size(); ++j) {
      const double reach = radius_ + outside_ + 0.5 * outlines[j].diameter + 3.0 * outlines[j].blur_px;
      if (j != index && cv::norm(outlines[j].centre - outline_.centre) < reach) near_.push_back(j);
    }
  }

  std::vector<Profile> take() {
    const cv::Point2d centre = map_.to_image(outline_.centre);
    const double scale = map_.image_px_per_plane_px(centre);
    const double reach = scale * (radius_ + outside_) * 1.02 + 1.0, hole = scale * (radius_ - inside_) * 0.98;
    for (int row = static_cast<int>(centre.y - reach); row <= static_cast<int>(centre.y + reach) + 1; ++row) {
      const double y = row - centre.y;
      const double half = std::sqrt(std::max(0.0, reach * reach - y * y));
      const double none = std::sqrt(std::max(0.0, hole * hole - y * y)) - 1.0;
      for (int column = static_cast<int>(centre.x - half); column <= static_cast<int>(centre.x + half);
           ++column) {
        if (std::abs(column - centre.x) < none) column = static_cast<int>(centre.x + none);
        add(column, row);
      }
    }
    return std::move(profiles_);
  }

 private:
  void add(int column, int row) {
    const cv::Point2d at = map_.to_plane(cv::Point2d(column, row));
    const cv::Point2d from = at - outline_.centre;
    const double depth = radius_ - cv::norm(from);
    if (depth < -outside_ || depth > inside_) return;
    const double angle = full_turn(std::atan2(from.y, from.x));
    Profile& profile =
        profiles_[static_cast<std::size_t>(angle / (2.0 * std::numbers::pi) * count_) % profiles_.size()];
    if (profile.crossed) return;
    if (column < 0 || row < 0 || column >= photograph_.width() || row >= photograph_.height() ||
        crosses_another(at)) {
      profile.crossed = true;
      return;
    }
    const float light = photograph_.intensity.at<float>(row, column);
    if (light >= photograph_.saturation) {
      profile.crossed = true;
      return;
    }
    if (profile.clear) profile.clear = !in_another(at);
    Bin& bin = profile.bins[static_cast<std::size_t>((depth + outside_) / kBin_px)];
    bin.depth_px += depth;
    bin.light += static_cast<double>(light);
    ++bin.pixels;
    if (depth > -0.5 * outside_) return;
    ++profile.outside;
    profile.black += light <= 0.0F ? 1 : 0;
  }

  double beyond(std::size_t other, cv::Point2d at) const {
    return cv::norm(at - outlines_[other].centre) - 0.5 * outlines_[other].diameter;
  }
  bool crosses_another(cv::Point2d at) const {
    return std::ranges::any_of(
        near_, [&](std::size_t j) { return std::abs(beyond(j, at)) < 3.0 * outlines_[j].blur_px; });
  }
  bool in_another(cv::Point2d at) const {
    return std::ranges::any_of(near_, [&](std::size_t j) { return beyond(j, at) < 0.0; });
  }

  const Photograph& photograph_;
  const PlaneMap& map_;
  std::span<const Outline> outlines_;
  const Outline& outline_;
  double radius_ = 0.0, outside_ = 0.0, inside_ = 0.0;
  int count_ = 0;
  std::vector<Profile> profiles_;
  std::vector<std::size_t> near_;
};

/// outside, step, root; place and width of the edge.
constexpr int kParameters = 5;
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;

struct Normal {
  Matrix matrix = Matrix::Zero();
  Vector right = Vector::Zero();
  double squares = 0.0, weights = 0.0;
  int bins = 0;
};

Normal normal_equations(const Profile& profile, const Vector& p) {
  Normal normal;
  for (const Bin& bin : profile.bins) {
    if (bin.pixels == 0) continue;
    const double depth = bin.depth_px / bin.pixels - p[3];
    const auto step = digitize::blurred_step(depth, p[4]), root = digitize::blurred_sqrt(depth, p[4]);
    Vector slope;
    slope << 1.0, step.value, root.value, -(p[1] * step.by_depth + p[2] * root.by_depth),
        p[1] * step.by_sigma + p[2] * root.by_sigma;
    const double residual = bin.light / bin.pixels - p[0] - p[1] * step.value - p[2] * root.value;
    normal.matrix += bin.pixels * slope * slope.transpose();
    normal.right += bin.pixels * residual * slope;
    normal.squares += bin.pixels * residual * residual;
    ++normal.bins;
  }
  return normal;
}

/// Place and width held.
std::optional<Vector> fit_light(const Profile& profile, double blur_px) {
  Vector p = Vector::Zero();
  p[4] = blur_px;
  Normal normal = normal_equations(profile, p);
  if (normal.bins <= 2 * kParameters) return std::nullopt;
  const Eigen::Vector3d light = normal.matrix.topLeftCorner<3, 3>().ldlt().solve(normal.right.head<3>());
  if (!light.allFinite()) return std::nullopt;
  p.head<3>() = light;
  return p;
}

/// Gauss-Newton; nullopt where the profile tells no edge.
std::optional<LimbSector::Edge> fit_edge(const Profile& profile, Vector p) {
  constexpr int kSteps = 8;
  constexpr double kMinBlur_px = 0.2, kMaxBlur_px = 20.0;
  Normal normal;
  for (int k = 0; k < kSteps; ++k) {
    normal = normal_equations(profile, p);
    Vector change = normal.matrix.ldlt().solve(normal.right);
    if (!change.allFinite()) return std::nullopt;
    change[3] = std::clamp(change[3], -0.5 * p[4], 0.5 * p[4]);
    change[4] = std::clamp(change[4], -0.3 * p[4], 0.3 * p[4]);
    p += change;
    if (p[4] < kMinBlur_px || p[4] > kMaxBlur_px) return std::nullopt;
  }
  const double variance = normal.squares / (normal.bins - kParameters);
  const double blur_variance = variance * normal.matrix.ldlt().solve(Vector::Unit(4))[4];
  if (!(blur_variance > 0.0)) return std::nullopt;
  return LimbSector::Edge{p[4], std::sqrt(blur_variance)};
}

std::optional<LimbSector> sector_of(const Profile& profile, double blur_px) {
  const auto light = fit_light(profile, blur_px);
  if (!light) return std::nullopt;
  LimbSector sector;
  sector.rise = (*light)[1] + (*light)[2] * std::sqrt(kInside_px);
  sector.clear = profile.clear;
  sector.outside = (*light)[0];
  sector.black_share = profile.outside > 0 ? static_cast<double>(profile.black) / profile.outside : 0.0;
  if (profile.seen) sector.edge = fit_edge(profile, *light);
  return sector;
}

}  // namespace

std::vector<LimbSector> limb_sectors(const Photograph& photograph, const PlaneMap& map,
                                     std::span<const Outline> outlines) {
  std::vector<LimbSector> sectors;
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    const std::vector<Profile> profiles = Ring(photograph, map, outlines, i).take();
    for (std::size_t k = 0; k < profiles.size(); ++k) {
      if (profiles[k].crossed) continue;
      auto sector = sector_of(profiles[k], outlines[i].blur_px);
      if (!sector) continue;
      sector->outline = i;
      sector->normal_rad =
          2.0 * std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(profiles.size());
      sectors.push_back(*sector);
    }
  }
  return sectors;
}

}  // namespace strobe::light
