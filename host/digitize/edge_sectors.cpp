#include "host/digitize/edge_sectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/digitize/annulus.hpp"
#include "host/digitize/edge_profile.hpp"

namespace strobe::digitize {

namespace {

constexpr int kMostNeighbours = 3;
constexpr int kOwn = 7;  // linear terms without neighbours
constexpr int kMostLinear = kOwn + 2 * kMostNeighbours;
constexpr int kExtra = 5;  // derivatives of step and root by depth and sigma, light
constexpr int kMost = kMostLinear + kExtra;
constexpr int kStep = 3, kRoot = 4;

using Matrix = std::array<std::array<double, kMost>, kMost>;

struct Normal {
  Matrix m{};
  int linear = kOwn;
  int pixels = 0;
};

/// The neighbours whose limb lies in the sector.
int choose_neighbours(std::span<const OutlineShape> neighbours, cv::Point2d middle, double window,
                      double sigma, std::array<const OutlineShape*, kMostNeighbours>& chosen) {
  int count = 0;
  for (const OutlineShape& other : neighbours) {
    const double depth = other.depth(middle);
    if (depth < -window - 4.0 * sigma || depth > 2.0 * window) continue;
    if (count < kMostNeighbours) chosen[static_cast<std::size_t>(count++)] = &other;
  }
  return count;
}

/// Foreshortened surface of a sphere towards the camera at that depth, over sqrt(2/R).
double sphere_factor(double depth, double radius) {
  return std::sqrt(std::max(0.25, 1.0 - 0.5 * depth / radius));
}

Normal accumulate(const SectorPixels& pixels, int index, const OutlineShape& shape,
                  std::span<const OutlineShape* const> neighbours, double sigma) {
  Normal normal;
  normal.linear = kOwn + 2 * static_cast<int>(neighbours.size());
  const int linear = normal.linear, terms = linear + kExtra;
  const double window = pixels.window_px();
  const cv::Point2d out = pixels.direction(index);
  const double shift = inward_shift(shape.radius, sigma);
  const double root_scale = 1.0 / std::sqrt(window);
  std::array<double, kMost> row{};
  for (const auto& pixel : pixels.sector(index)) {
    const cv::Point2d at(pixel.x, pixel.y);
    const double depth = shape.depth(at) - shift;
    const Blurred step = blurred_step(depth, sigma), root = blurred_root(depth, sigma);
    const double factor = sphere_factor(depth, shape.radius) * root_scale;
    const double along = ((at.y - shape.centre.y) * out.x - (at.x - shape.centre.x) * out.y) / window;
    const double inwards = depth / window;
    row[0] = 1.0;
    row[1] = inwards;
    row[2] = along;
    row[kStep] = step.value;
    row[kRoot] = root.value * factor;
    row[5] = step.value * inwards;
    row[6] = step.value * along;
    std::size_t next = kOwn;
    for (const OutlineShape* other : neighbours) {
      const double theirs = other->depth(at) - shift;
      row[next++] = blurred_step(theirs, sigma).value;
      row[next++] = blurred_root(theirs, sigma).value * root_scale;
    }
    row[next++] = step.by_depth;
    row[next++] = root.by_depth * factor;
    row[next++] = step.by_sigma;
    row[next++] = root.by_sigma * factor;
    row[next++] = pixel.light;
    for (std::size_t i = 0; i < static_cast<std::size_t>(terms); ++i)
      for (std::size_t j = 0; j <= i; ++j) normal.m[i][j] += row[i] * row[j];
    ++normal.pixels;
  }
  return normal;
}

/// Takes the linear terms out of the rest: afterwards m[i][j] of the rest is what is left of their products,
/// and m[last][j] of a linear term j holds L⁻¹ of its product with the light (Cholesky, row by row).
void project(Normal& normal) {
  const auto linear = static_cast<std::size_t>(normal.linear), terms = linear + kExtra;
  for (std::size_t j = 0; j < linear; ++j) normal.m[j][j] *= 1.0 + 1e-7;
  for (std::size_t i = 0; i < terms; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = normal.m[i][j];
      for (std::size_t k = 0; k < std::min(j, linear); ++k) sum -= normal.m[i][k] * normal.m[j][k];
      if (j >= linear) {
        normal.m[i][j] = sum;
      } else if (i == j) {
        normal.m[i][i] = std::sqrt(std::max(sum, 1e-12));
      } else {
        normal.m[i][j] = sum / normal.m[j][j];
      }
    }
  }
}

/// The linear terms' coefficients, by back substitution.
std::array<double, kMostLinear> coefficients(const Normal& normal) {
  std::array<double, kMostLinear> x{};
  const int linear = normal.linear;
  const auto& light = normal.m[static_cast<std::size_t>(linear + kExtra - 1)];
  for (int i = linear - 1; i >= 0; --i) {
    const auto row = static_cast<std::size_t>(i);
    double sum = light[row];
    for (int k = i + 1; k < linear; ++k)
      sum -= normal.m[static_cast<std::size_t>(k)][row] * x[static_cast<std::size_t>(k)];
    x[row] = sum / normal.m[row][row];
  }
  return x;
}

}  // namespace

SectorPixels::SectorPixels(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape,
                           int sectors, double outside_px, double inside_px)
    : sectors_(static_cast<std::size_t>(sectors)), window_(std::max(outside_px, inside_px)) {
  const double oval =
      std::hypot(shape.oval_cos, shape.oval_sin) + shape.radius * (std::max(shape.along, shape.across) - 1.0);
  const auto full = static_cast<float>(0.985 * photograph.saturation);
  const double expected = 2.0 * std::numbers::pi * shape.radius * (outside_px + inside_px) / sectors;
  int visited = 0;  // every second pixel is enough: blur and felt make neighbours alike
  visit_annulus(photograph, frame, shape.centre, shape.radius - inside_px - oval,
                shape.radius + outside_px + oval, [&](cv::Point2d at, float light) {
                  const double x = at.x - shape.centre.x, y = at.y - shape.centre.y;
                  const double depth = shape.depth(at);
                  if (depth < -outside_px || depth > inside_px) return;
                  const double turn = cv::fastAtan2(static_cast<float>(y), static_cast<float>(x)) / 360.0;
                  Sector& sector = sectors_[static_cast<std::size_t>(turn * sectors) % sectors_.size()];
                  sector.present += 1.0;
                  if (light >= full) {
                    sector.saturated += 1.0;
                    double& nearest = depth > 0.0 ? sector.saturated_inside : sector.saturated_outside;
                    nearest = depth > 0.0 ? std::min(nearest, depth) : std::max(nearest, depth);
                  } else if (++visited % 2 == 0) {
                    sector.pixels.push_back({static_cast<float>(at.x), static_cast<float>(at.y), light});
                  }
                });
  for (Sector& sector : sectors_) {
    // Of a depth at which some pixels are saturated the others are the darker ones, and would mislead.
    if (sector.saturated > 0.0) {
      std::erase_if(sector.pixels, [&](const Pixel& pixel) {
        const double depth = shape.depth({pixel.x, pixel.y});
        return depth > sector.saturated_inside - 1.0 || depth < sector.saturated_outside + 1.0;
      });
    }
    if (sector.present > 0.0) sector.saturated /= sector.present;
    sector.present = std::min(1.0, sector.present / expected);
  }
}

double SectorPixels::angle(int index) const { return 2.0 * std::numbers::pi * (index + 0.5) / count(); }

cv::Point2d SectorPixels::direction(int index) const {
  return {std::cos(angle(index)), std::sin(angle(index))};
}

SectorEdge fit_sector(const SectorPixels& pixels, int index, const OutlineShape& shape,
                      std::span<const OutlineShape> neighbours, double sigma_px) {
  SectorEdge edge;
  const cv::Point2d out = pixels.direction(index);
  const cv::Point2d middle = shape.centre + out * shape.reach(out.x, out.y);
  std::array<const OutlineShape*, kMostNeighbours> chosen{};
  const int others = choose_neighbours(neighbours, middle, pixels.window_px(), sigma_px, chosen);
  Normal normal =
      accumulate(pixels, index, shape, std::span(chosen).first(static_cast<std::size_t>(others)), sigma_px);
  if (!pixels.clear_of_saturation(index, 1.5 * sigma_px)) return edge;
  const int spare = normal.pixels - normal.linear - 2;
  if (spare < normal.linear) return edge;
  project(normal);
  const auto x = coefficients(normal);
  const double step = x[kStep], root = x[kRoot];
  const auto first = static_cast<std::size_t>(normal.linear);
  const auto rest = [&](std::size_t i, std::size_t j) {
    return normal.m[first + std::max(i, j)][first + std::min(i, j)];
  };
  const double depth_depth =
      step * step * rest(0, 0) + 2 * step * root * rest(0, 1) + root * root * rest(1, 1);
  const double sigma_sigma =
      step * step * rest(2, 2) + 2 * step * root * rest(2, 3) + root * root * rest(3, 3);
  const double depth_sigma =
      step * step * rest(0, 2) + step * root * (rest(0, 3) + rest(1, 2)) + root * root * rest(1, 3);
  const double depth_light = step * rest(0, 4) + root * rest(1, 4);
  const double sigma_light = step * rest(2, 4) + root * rest(3, 4);
  const double noise2 = std::max(rest(4, 4), 0.0) / spare + 1e-14;
  edge.rise = step + root * blurred_root(2.0 * sigma_px, sigma_px).value / std::sqrt(pixels.window_px());
  if (!(edge.rise > 0.0) || !(depth_depth > 0.0)) return edge;
  edge.usable = true;
  edge.offset_px = depth_light / depth_depth;
  edge.sd_px = std::sqrt(noise2 / depth_depth);
  const double sigma_left = sigma_sigma - depth_sigma * depth_sigma / depth_depth;
  edge.sigma_weight = std::max(0.0, sigma_left) / noise2;
  edge.sigma_change = (sigma_light - depth_sigma * edge.offset_px) / noise2;
  return edge;
}

}  // namespace strobe::digitize
