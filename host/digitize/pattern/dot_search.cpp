#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "host/digitize/core/statistics.hpp"
#include "host/digitize/equator/shading.hpp"
#include "host/digitize/pattern/dot_pattern.hpp"

namespace strobe::digitize {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kFineRadius_px = 64.0;  ///< more pixels tell no more than their means do
constexpr double kStartWidth = 0.09;     ///< sd of a dot's darkness, radii
constexpr double kOfDarkest = 0.25;
constexpr std::size_t kMaxDots = 24;
// So near the limb a dot is a sliver that shading hides.
constexpr double kFarthest = 0.93;

/// How much darker than its shading the ball is, over the bins of its square.
struct Darkness {
  const Disc* disc = nullptr;
  const BinnedImage* image = nullptr;
  cv::Rect bins;
  cv::Mat share;       ///< CV_32F
  cv::Mat weight;      ///< CV_32F, relative inverse variance; 0 outside
  double noise = 0.0;  ///< sd of one bin of weight one

  Vector2d unit(int i, int j) const {
    const cv::Point2d at = disc->unit(image->column(bins.x + i), image->row(bins.y + j));
    return {at.x, at.y};
  }
};

/// `blur`: of the outline, sd in radii; the edge takes light from within.
Darkness darkness_of(const BinnedImage& image, const Disc& disc, const Shading& shading, double blur) {
  Darkness dark{&disc, &image, image.around(disc, 1.0), {}, {}, 0.0};
  dark.share = cv::Mat::zeros(dark.bins.size(), CV_32F);
  dark.weight = cv::Mat::zeros(dark.bins.size(), CV_32F);
  const float middle = shading.at(0.0F, 0.0F, 1.0F);
  const double reach = 1.0 - std::max(blur, 0.02);
  for (int j = 0; j < dark.bins.height; ++j) {
    for (int i = 0; i < dark.bins.width; ++i) {
      const Vector2d at = dark.unit(i, j);
      const double z2 = 1.0 - at.squaredNorm();
      if (z2 <= 1.0 - reach * reach) continue;
      const double edge = 0.5 * std::erfc((at.norm() - 1.0) / (std::numbers::sqrt2 * std::max(blur, 1e-3)));
      const auto u = static_cast<float>(at.x()), v = static_cast<float>(at.y());
      const float light = static_cast<float>(edge) * shading.at(u, v, static_cast<float>(std::sqrt(z2)));
      const float seen = image.intensity.at<float>(dark.bins.y + j, dark.bins.x + i);
      if (light < 0.15F * middle || seen >= image.saturation) continue;
      dark.share.at<float>(j, i) = 1.0F - (seen - shading.background) / light;
      dark.weight.at<float>(j, i) = (light / middle) * (light / middle);
    }
  }
  return dark;
}

/// Sd of a bin's noise from differences of neighbours, which nothing on the ball disturbs much.
double noise_of(const Darkness& dark) {
  std::vector<double> differences;
  for (int j = 0; j < dark.share.rows; ++j) {
    for (int i = 0; i + 1 < dark.share.cols; ++i) {
      const float a = dark.weight.at<float>(j, i), b = dark.weight.at<float>(j, i + 1);
      if (a > 0.0F && b > 0.0F)
        differences.push_back(std::abs(dark.share.at<float>(j, i) - dark.share.at<float>(j, i + 1)) /
                              std::sqrt(1.0F / a + 1.0F / b));
    }
  }
  return differences.empty() ? 0.0 : kSdOverMad * upper_median(std::move(differences));
}

/// Covariance of a dot's darkness over the disc: round on the ball, foreshortened, and as blurred as
/// everything.
Matrix2d spread_of(const Vector2d& at, double width, double blur) {
  return width * width * (Matrix2d::Identity() - at * at.transpose()) + blur * blur * Matrix2d::Identity();
}

struct Moments {
  double sum = 0.0;  ///< of window times darkness
  Vector2d mean;
  Matrix2d second, noise;
  double window = 0.0;
};

/// Darkness about a place, in a Gaussian window.
Moments moments(const Darkness& dark, const Vector2d& at, const Matrix2d& window) {
  const Matrix2d inverse = window.inverse();
  const double reach = 3.0 * std::sqrt(window.trace());
  const Disc& disc = *dark.disc;
  const cv::Vec2d middle = disc.image_from_unit * cv::Vec2d(at.x(), at.y());
  const double stride = dark.image->stride;
  const int column = cvRound((disc.centre_image.x + middle[0] - dark.image->column(dark.bins.x)) / stride);
  const int row = cvRound((disc.centre_image.y + middle[1] - dark.image->row(dark.bins.y)) / stride);
  const int bins = static_cast<int>(reach * disc.radius_image_px / stride) + 1;
  Moments m{0.0, Vector2d::Zero(), Matrix2d::Zero(), Matrix2d::Zero(), 0.0};
  for (int j = std::max(0, row - bins); j <= std::min(dark.share.rows - 1, row + bins); ++j) {
    for (int i = std::max(0, column - bins); i <= std::min(dark.share.cols - 1, column + bins); ++i) {
      const double weight = dark.weight.at<float>(j, i);
      if (weight <= 0.0) continue;
      const Vector2d off = dark.unit(i, j) - at;
      const double w = std::exp(-0.5 * off.dot(inverse * off));
      const double share = dark.share.at<float>(j, i);
      m.window += w;
      m.sum += w * share;
      m.mean += w * share * off;
      m.second += w * share * off * off.transpose();
      m.noise += w * w / weight * off * off.transpose();
    }
  }
  m.noise *= dark.noise * dark.noise;
  return m;
}

/// The centroid in a window of the dot's own size that moves with it: for a symmetric dot twice the window's
/// mean leads to its middle. Nullopt if it wanders off.
std::optional<SeenDot> centroid(const Darkness& dark, const Vector2d& start, double width, double blur) {
  SeenDot dot{start, Matrix2d::Zero(), 0.0};
  for (int step = 0; step < 12; ++step) {
    const Matrix2d window = spread_of(dot.at, width, blur);
    const Moments m = moments(dark, dot.at, window);
    if (!(m.sum > 0.0)) return std::nullopt;
    const Vector2d change = 2.0 * m.mean / m.sum;
    dot.at += change;
    // The window's mean of a Gaussian of the window's size is half its middle.
    dot.darkness = 2.0 * m.sum / m.window;
    dot.covariance = 4.0 / (m.sum * m.sum) * m.noise;
    if (!(dot.at.norm() < kFarthest) || (dot.at - start).norm() > 1.5 * kStartWidth) return std::nullopt;
    if (change.norm() < 1e-4) break;
  }
  return dot;
}

/// The dots' common width: their second moment along the limb, which nothing foreshortens, with the window's
/// taken out.
double common_width(const Darkness& dark, const std::vector<SeenDot>& dots, double width, double blur) {
  std::vector<double> widths;
  for (const SeenDot& dot : dots) {
    if (dot.at.norm() > kSurelySeen) continue;
    const Moments m = moments(dark, dot.at, spread_of(dot.at, width, blur));
    const Vector2d along = Vector2d(-dot.at.y(), dot.at.x() + 1e-9).normalized();
    const double window = width * width + blur * blur;
    const double seen = along.dot(m.second * along) / m.sum;
    if (seen > 0.0 && seen < 0.9 * window) widths.push_back(1.0 / (1.0 / seen - 1.0 / window) - blur * blur);
  }
  if (widths.empty()) return width;
  return std::sqrt(std::clamp(upper_median(std::move(widths)), 0.03 * 0.03, 0.15 * 0.15));
}

std::vector<Vector2d> dark_places(const Darkness& dark) {
  const double sd = 0.5 * kStartWidth * dark.disc->radius_image_px / dark.image->stride;
  cv::Mat sum, weight, norm;
  const cv::Mat usable = dark.weight > 0.0F;
  usable.convertTo(weight, CV_32F, 1.0 / 255.0);
  cv::GaussianBlur(dark.share, sum, {}, sd, sd, cv::BORDER_CONSTANT);
  cv::GaussianBlur(weight, norm, {}, sd, sd, cv::BORDER_CONSTANT);
  cv::Mat smooth = sum / cv::max(norm, 0.3F);
  const double noise = dark.noise / std::max(1.0, 2.0 * std::sqrt(CV_PI) * sd);
  double darkest = 0.0;
  cv::minMaxLoc(smooth, nullptr, &darkest, nullptr, nullptr, usable);
  const auto least = static_cast<float>(std::max(kFarthest_sd * noise, kOfDarkest * darkest));
  cv::Mat around;
  const int side = 2 * std::max(1, cvRound(1.2 * sd)) + 1;
  cv::dilate(smooth, around, cv::Mat::ones(side, side, CV_8U));
  std::vector<std::pair<float, Vector2d>> places;
  for (int j = 0; j < smooth.rows; ++j)
    for (int i = 0; i < smooth.cols; ++i)
      if (const float value = smooth.at<float>(j, i);
          usable.at<std::uint8_t>(j, i) != 0 && value >= least && value >= around.at<float>(j, i))
        places.emplace_back(value, dark.unit(i, j));
  std::ranges::stable_sort(places, [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Vector2d> result;
  for (const auto& [value, at] : places)
    if (result.size() < kMaxDots) result.push_back(at);
  return result;
}

std::vector<SeenDot> centroids(const Darkness& dark, const std::vector<Vector2d>& places, double width,
                               double blur) {
  std::vector<SeenDot> dots;
  for (const Vector2d& place : places) {
    const auto dot = centroid(dark, place, width, blur);
    if (!dot) continue;
    const bool same = std::ranges::any_of(
        dots, [&](const SeenDot& other) { return (other.at - dot->at).norm() < 0.3 * kStartWidth; });
    if (!same) dots.push_back(*dot);
  }
  return dots;
}

/// A dot of radius a is a flat disc at cos(a) from the ball's middle, and its darkness has sd a/2. What is
/// left of shading and of the outline's blur moves dots by so much more than noise; from rendered balls.
void on_sphere(SeenDot& dot, double width, double blur) {
  constexpr double kShading = 0.025, kLimb = 0.16;  // of the blur's sd
  const double sd = blur * std::hypot(kShading, kLimb * std::pow(dot.at.norm(), 6.0));
  dot.covariance += sd * sd * Matrix2d::Identity();
  dot.at /= std::cos(2.0 * width);
}

}  // namespace

std::vector<SeenDot> find_dots(const Photograph& photograph, const PlaneMap& map, const Outline& outline) {
  const Disc disc = make_disc(map, outline);
  if (!is_valid(disc)) return {};
  const int stride = std::max(1, static_cast<int>(disc.radius_image_px / kFineRadius_px));
  const std::array discs{disc};
  const BinnedImage image = bin_image(photograph, discs, stride);
  if (image.intensity.empty() || image.around(disc, 1.0).empty()) return {};
  const auto shadings = fit_shadings(image, discs, 60);
  const double blur = outline.blur_px * map.image_px_per_plane_px(disc.centre_image) / disc.radius_image_px;
  Darkness dark = darkness_of(image, disc, shadings.front(), blur);
  dark.noise = noise_of(dark);
  const auto places = dark_places(dark);
  const auto first = centroids(dark, places, kStartWidth, blur);
  const double width = common_width(dark, first, kStartWidth, blur);
  auto dots = centroids(dark, places, width, blur);
  for (SeenDot& dot : dots) on_sphere(dot, width, blur);
  return dots;
}

}  // namespace strobe::digitize
