#include "host/digitize/edge_sectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>

namespace strobe::digitize {

namespace {

constexpr int kMostNeighbours = 3;
constexpr int kOwn = 5;  // linear terms without neighbours
constexpr int kMostLinear = kOwn + 2 * kMostNeighbours;
constexpr int kExtra = 5;  // derivatives of step and root by depth and sigma, light
constexpr int kMost = kMostLinear + kExtra;
constexpr int kStep = 2, kRoot = 3;
constexpr int kLanes = 4;
constexpr int kMostDepths = 64;
constexpr int kFewestSpare = 4;
// Interpolation between pixels takes a third of white noise's variance away and leaves what a fit's error is
// made of, its slow part, as it was (a cubic B-spline's values at 0, ±1: 2/3, 1/6).
constexpr double kSmoothed = 1.5;

/// The sector's light and terms, a row each, by depth; and the sums of their products.
struct Terms {
  alignas(16) std::array<std::array<float, kMostDepths>, kMost> row;
  int linear = kOwn;
  int depths = 0;

  int count() const { return linear + kExtra; }
  void pad() {
    while (depths % kLanes != 0) {
      for (int i = 0; i < count(); ++i)
        row[static_cast<std::size_t>(i)][static_cast<std::size_t>(depths)] = 0.0F;
      ++depths;
    }
  }
};

struct Normal {
  std::array<std::array<double, kMost>, kMost> m;
  int linear = kOwn;
};

Normal products(const Terms& terms) {
  Normal normal;
  normal.linear = terms.linear;
  for (std::size_t i = 0; i < static_cast<std::size_t>(terms.count()); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      cv::v_float32x4 sum = cv::v_setzero_f32();
      for (std::size_t k = 0; k < static_cast<std::size_t>(terms.depths); k += kLanes)
        sum = cv::v_muladd(cv::v_load_aligned(&terms.row[i][k]), cv::v_load_aligned(&terms.row[j][k]), sum);
      normal.m[i][j] = cv::v_reduce_sum(sum);
    }
  }
  return normal;
}

using Chosen = std::array<const OutlineShape*, kMostNeighbours>;

/// The neighbours whose limb lies in the sector, the nearest ones.
int choose_neighbours(std::span<const OutlineShape> neighbours, cv::Point2d middle, double window,
                      double sigma, Chosen& chosen) {
  int count = 0;
  std::array<double, kMostNeighbours> distance{};
  for (const OutlineShape& other : neighbours) {
    const double depth = other.depth(middle);
    if (depth < -window - 4.0 * sigma || depth > 2.0 * window) continue;
    int at = count < kMostNeighbours ? count++ : kMostNeighbours;
    for (; at > 0 && distance[static_cast<std::size_t>(at - 1)] > std::abs(depth); --at) {
      if (at == kMostNeighbours) continue;
      distance[static_cast<std::size_t>(at)] = distance[static_cast<std::size_t>(at - 1)];
      chosen[static_cast<std::size_t>(at)] = chosen[static_cast<std::size_t>(at - 1)];
    }
    if (at == kMostNeighbours) continue;
    distance[static_cast<std::size_t>(at)] = std::abs(depth);
    chosen[static_cast<std::size_t>(at)] = &other;
  }
  return count;
}

void put_neighbour(Terms& terms, std::size_t first, const SectorLight& light, int index, double shift,
                   const OutlineShape& other, const ProfileTable& profiles) {
  const SectorLight::Profile profile = light.profile(index);
  const cv::Point2d out = light.direction(index);
  const double slope = std::tan(light.half_width_rad());
  for (std::size_t k = 0; k < profile.light.size(); ++k) {
    const double depth = profile.depth_px + static_cast<double>(k) * light.depth_step_px();
    const cv::Point2d at = light.middle(index) - depth * out;
    const cv::Point2d side = slope * light.reach_px(index, depth) * cv::Point2d(-out.y, out.x);
    const auto [step, root] = profiles.mean(other.depth(at - side) - shift, other.depth(at + side) - shift);
    terms.row[first][k] = step;
    terms.row[first + 1][k] = root;
  }
}

Terms terms_of(const SectorLight& light, int index, const OutlineShape& shape,
               std::span<const OutlineShape* const> neighbours, const ProfileTable& profiles, double sigma) {
  Terms terms;
  terms.linear = kOwn + 2 * static_cast<int>(neighbours.size());
  const SectorLight::Profile profile = light.profile(index);
  const double shift = inward_shift(shape.radius, sigma);
  const double moved = profile.depth_px + shape.depth(light.middle(index)) - shift;
  const double unit = 1.0 / light.window_px();
  const auto extra = static_cast<std::size_t>(terms.linear);
  for (std::size_t k = 0; k < profile.light.size(); ++k) {
    const double depth = moved + static_cast<double>(k) * light.depth_step_px();
    const ProfileTable::Entry entry = profiles.at(depth);
    const auto inwards = static_cast<float>(depth * unit);
    terms.row[0][k] = 1.0F;
    terms.row[1][k] = inwards;
    terms.row[kStep][k] = entry.step;
    terms.row[kRoot][k] = entry.root;
    terms.row[4][k] = entry.step * inwards;
    terms.row[extra][k] = entry.step_by_depth;
    terms.row[extra + 1][k] = entry.root_by_depth;
    terms.row[extra + 2][k] = entry.step_by_sigma;
    terms.row[extra + 3][k] = entry.root_by_sigma;
    terms.row[extra + 4][k] = profile.light[k];
  }
  std::size_t next = kOwn;
  for (const OutlineShape* other : neighbours) {
    put_neighbour(terms, next, light, index, shift, *other, profiles);
    next += 2;
  }
  terms.depths = static_cast<int>(profile.light.size());
  terms.pad();
  return terms;
}

/// Takes the linear terms out of the rest: afterwards m[i][j] of the rest is what is left of their products,
/// and m[last][j] of a linear term j holds L⁻¹ of its product with the light (Cholesky, row by row).
void project(Normal& normal) {
  const auto linear = static_cast<std::size_t>(normal.linear), terms = linear + kExtra;
  for (std::size_t j = 0; j < linear; ++j) normal.m[j][j] *= 1.0 + 1e-6;
  for (std::size_t i = 0; i < terms; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = normal.m[i][j];
      for (std::size_t k = 0; k < std::min(j, linear); ++k) sum -= normal.m[i][k] * normal.m[j][k];
      if (j >= linear) {
        normal.m[i][j] = sum;
      } else if (i == j) {
        normal.m[i][i] = std::sqrt(std::max(sum, 1e-9));
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

/// What is left of a projected sector's terms, by the step's and root's own sizes.
SectorEdge edge_of(const Normal& normal, double spare) {
  SectorEdge edge;
  const auto x = coefficients(normal);
  const double step = x[kStep], root = x[kRoot];
  const auto first = static_cast<std::size_t>(normal.linear);
  const auto rest = [&](std::size_t i, std::size_t j) {
    return normal.m[first + std::max(i, j)][first + std::min(i, j)];
  };
  const auto square = [&](std::size_t a, std::size_t b) {
    return step * step * rest(a, a) + 2 * step * root * rest(a, b) + root * root * rest(b, b);
  };
  const double depth_depth = square(0, 1), sigma_sigma = square(2, 3);
  const double depth_sigma =
      step * step * rest(0, 2) + step * root * (rest(0, 3) + rest(1, 2)) + root * root * rest(1, 3);
  const double depth_light = step * rest(0, 4) + root * rest(1, 4);
  const double sigma_light = step * rest(2, 4) + root * rest(3, 4);
  const double noise2 = kSmoothed * std::max(rest(4, 4), 0.0) / spare + 1e-14;
  if (!(depth_depth > 0.0)) return edge;
  edge.usable = true;
  edge.offset_px = depth_light / depth_depth;
  edge.sd_px = std::sqrt(noise2 / depth_depth);
  const double sigma_left = sigma_sigma - depth_sigma * depth_sigma / depth_depth;
  edge.sigma_weight = std::max(0.0, sigma_left) / noise2;
  edge.sigma_change = (sigma_light - depth_sigma * edge.offset_px) / noise2;
  return edge;
}

/// One sampled place.
struct Sample {
  float light = 0.0F;
  bool present = false, saturated = false;
};

class Sampler {
 public:
  explicit Sampler(const Photograph& photograph)
      : light_(photograph.light), full_(static_cast<float>(0.985 * photograph.saturation)) {}

  Sample at(cv::Point2d image) const {
    const double x = std::floor(image.x), y = std::floor(image.y);
    if (!(x >= 0.0 && y >= 0.0 && x + 1.0 < light_.cols && y + 1.0 < light_.rows)) return {};
    const float* above = light_.ptr<float>(static_cast<int>(y)) + static_cast<int>(x);
    const float* below = above + light_.step1();
    const auto u = static_cast<float>(image.x - x), v = static_cast<float>(image.y - y);
    const float top = above[0] + u * (above[1] - above[0]), bottom = below[0] + u * (below[1] - below[0]);
    const float most = std::max(std::max(above[0], above[1]), std::max(below[0], below[1]));
    return {top + v * (bottom - top), true, most >= full_};
  }

 private:
  const cv::Mat& light_;
  float full_;
};

}  // namespace

SectorLight::SectorLight(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape,
                         const SectorGrid& grid)
    : sectors_(static_cast<std::size_t>(grid.sectors)),
      outside_(grid.outside_px),
      window_(std::max(grid.outside_px, grid.inside_px)) {
  const double across = grid.outside_px + grid.inside_px;
  // Enough depths to tell the terms apart, where a ball is small.
  step_ = std::max(across / (kMostDepths - 1), std::min(1.0, across / 20.0));
  depths_ = std::min(kMostDepths, static_cast<int>(across / step_) + 1);
  light_.assign(sectors_.size() * static_cast<std::size_t>(depths_), 0.0F);
  std::vector<int> flawed;
  for (int i = 0; i < count(); ++i) sample(photograph, frame, shape, i, grid.rays, flawed);
}

void SectorLight::sample(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape,
                         int index, int rays, std::vector<int>& flawed) {
  Sector& own = sectors_[static_cast<std::size_t>(index)];
  const Sampler sampler(photograph);
  float* light = &light_[static_cast<std::size_t>(index * depths_)];
  flawed.assign(static_cast<std::size_t>(depths_), 0);
  const double middle = angle(index);
  own.out = {std::cos(middle), std::sin(middle)};
  own.reach = shape.reach(own.out.x, own.out.y);
  own.middle = shape.centre + own.out * own.reach;
  int present = 0, saturated = 0;
  for (int ray = 0; ray < rays; ++ray) {
    const double turn = 2.0 * half_width_rad() * ((ray + 0.5) / rays - 0.5);
    const double c = std::cos(turn), s = std::sin(turn);
    const cv::Point2d out(own.out.x * c - own.out.y * s, own.out.x * s + own.out.y * c);
    const cv::Point2d outermost = shape.centre + out * (shape.reach(out.x, out.y) + outside_);
    const cv::Point2d from = frame.to_image(outermost);
    const cv::Point2d along = frame.is_plain() ? cv::Point2d(-out.x, out.y) * step_ : cv::Point2d();
    for (int k = 0; k < depths_; ++k) {
      const Sample one = sampler.at(frame.is_plain() ? from + static_cast<double>(k) * along
                                                     : frame.to_image(outermost - out * (k * step_)));
      light[k] += one.light;
      present += one.present ? 1 : 0;
      if (one.present && !one.saturated) continue;
      flawed[static_cast<std::size_t>(k)] = 1;
      if (!one.saturated) continue;
      ++saturated;
      const double depth = k * step_ - outside_;
      double& nearest = depth > 0.0 ? own.saturated_inside : own.saturated_outside;
      nearest = depth > 0.0 ? std::min(nearest, depth) : std::max(nearest, depth);
    }
  }
  for (int k = 0; k < depths_; ++k) light[k] /= static_cast<float>(rays);
  own.present = static_cast<double>(present) / (rays * depths_);
  own.saturated = present > 0 ? static_cast<double>(saturated) / present : 0.0;
  // Of a depth at which some pixels are saturated the others are the darker ones, and would mislead.
  const int outline = std::clamp(static_cast<int>(outside_ / step_ + 0.5), 0, depths_ - 1);
  const auto fine = [&](int k) {
    const double depth = k * step_ - outside_;
    return flawed[static_cast<std::size_t>(k)] == 0 && depth <= own.saturated_inside - 1.0 &&
           depth >= own.saturated_outside + 1.0;
  };
  if (!fine(outline)) return;
  int last = outline;
  own.first = outline;
  while (own.first > 0 && fine(own.first - 1)) --own.first;
  while (last + 1 < depths_ && fine(last + 1)) ++last;
  own.size = last - own.first + 1;
}

double SectorLight::angle(int index) const { return 2.0 * std::numbers::pi * (index + 0.5) / count(); }

double SectorLight::half_width_rad() const { return std::numbers::pi / count(); }

SectorLight::Profile SectorLight::profile(int index) const {
  const Sector& own = sector(index);
  const auto begin = static_cast<std::size_t>(index * depths_ + own.first);
  return {own.first * step_ - outside_, std::span(light_).subspan(begin, static_cast<std::size_t>(own.size))};
}

ProfileTable sector_profiles(const SectorLight& light, double radius_px, double sigma_px) {
  const double window = light.window_px();
  return {sigma_px, radius_px, window, -2.0 * window - 4.0 * sigma_px, 3.5 * window + 4.0 * sigma_px};
}

SectorEdge fit_sector(const SectorLight& light, int index, const OutlineShape& shape,
                      std::span<const OutlineShape> neighbours, const ProfileTable& profiles,
                      double sigma_px) {
  if (!light.clear_of_saturation(index, 1.5 * sigma_px)) return {};
  const cv::Point2d out = light.direction(index);
  const cv::Point2d middle = shape.centre + out * shape.reach(out.x, out.y);
  Chosen chosen{};
  const int others = choose_neighbours(neighbours, middle, light.window_px(), sigma_px, chosen);
  const int spare = static_cast<int>(light.profile(index).light.size()) - kOwn - 2 * others - 2;
  if (spare < kFewestSpare) return {};
  const Terms terms = terms_of(light, index, shape, std::span(chosen).first(static_cast<std::size_t>(others)),
                               profiles, sigma_px);
  Normal normal = products(terms);
  project(normal);
  const auto x = coefficients(normal);
  const double rise = x[kStep] + x[kRoot] * profiles.at(2.0 * sigma_px).root;
  return rise > 0.0 ? edge_of(normal, spare) : SectorEdge{};
}

}  // namespace strobe::digitize
