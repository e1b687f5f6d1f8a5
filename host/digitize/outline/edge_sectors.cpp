#include "host/digitize/outline/edge_sectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>
#include <optional>

namespace strobe::digitize {

namespace {

constexpr int kMaxNeighbours = 3;
constexpr int kOwn = 5;  // linear terms without neighbours
constexpr int kMaxLinear = kOwn + 2 * kMaxNeighbours;
constexpr int kExtra = 5;  // derivatives of step and root by depth and sigma, light
constexpr int kMaxTerms = kMaxLinear + kExtra;
constexpr int kStep = 2, kRoot = 3;
constexpr int kLanes = 4;
constexpr int kMaxDepths = 64;
constexpr int kFewestSpare = 4;
constexpr double kRough = 2.0;
// A neighbour's step and root are held near none, as if known to be less than some thirty times the noise:
// else limbs that run side by side with this one take all that it tells.
constexpr double kNeighbourDoubt = 1e-3;
// Interpolation between pixels takes a third of white noise's variance away and leaves what a fit's error is
// made of, its slow part, as it was (a cubic B-spline's values at 0, ±1: 2/3, 1/6).
constexpr double kSmoothed = 1.5;

/// The sector's light and terms, a row each, by depth; and the sums of their products.
struct Terms {
  alignas(16) std::array<std::array<float, kMaxDepths>, kMaxTerms> row;
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
  std::array<std::array<double, kMaxTerms>, kMaxTerms> m;
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

using Chosen = std::array<const OutlineShape*, kMaxNeighbours>;

/// The neighbours whose limb lies in the sector, the nearest ones.
int choose_neighbours(std::span<const OutlineShape> neighbours, cv::Point2d middle, double window,
                      double sigma, Chosen& chosen) {
  int count = 0;
  std::array<double, kMaxNeighbours> distance{};
  for (const OutlineShape& other : neighbours) {
    const double depth = other.depth(middle);
    if (depth < -window - 4.0 * sigma || depth > 2.0 * window) continue;
    int at = count < kMaxNeighbours ? count++ : kMaxNeighbours;
    for (; at > 0 && distance[static_cast<std::size_t>(at - 1)] > std::abs(depth); --at) {
      if (at == kMaxNeighbours) continue;
      distance[static_cast<std::size_t>(at)] = distance[static_cast<std::size_t>(at - 1)];
      chosen[static_cast<std::size_t>(at)] = chosen[static_cast<std::size_t>(at - 1)];
    }
    if (at == kMaxNeighbours) continue;
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
    terms.row[extra + 1][k] = entry.sqrt_by_depth;
    terms.row[extra + 2][k] = entry.step_by_sigma;
    terms.row[extra + 3][k] = entry.sqrt_by_sigma;
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
  for (std::size_t j = 0; j < linear; ++j)
    normal.m[j][j] = (1.0 + 1e-6) * normal.m[j][j] + (j < kOwn ? 0.0 : kNeighbourDoubt);
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
std::array<double, kMaxLinear> coefficients(const Normal& normal) {
  std::array<double, kMaxLinear> x{};
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
class Rest {
 public:
  Rest(const Normal& normal, double spare)
      : normal_(normal), first_(static_cast<std::size_t>(normal.linear)) {
    const auto x = coefficients(normal);
    step_ = x[kStep];
    root_ = x[kRoot];
    depth_depth_ = step_ * step_ * of(0, 0) + 2 * step_ * root_ * of(0, 1) + root_ * root_ * of(1, 1);
    noise2_ = kSmoothed * std::max(of(4, 4), 0.0) / spare + 1e-14;
    if (depth_depth_ > 0.0) offset_ = (step_ * of(0, 4) + root_ * of(1, 4)) / depth_depth_;
  }

  double step() const { return step_; }
  double root() const { return root_; }

  /// How far inside of the outline light may begin where no lamp reaches the limb: the light there would be
  /// below the background's, a negative step, and rises to it at (step/root)² of the window. Absent: it is
  /// so. The step's size for a given outline says nothing of where the sector would have the outline, so that
  /// no place is favoured; while the outline is still rough its own place must be allowed for.
  std::optional<double> unlit_depth(double window_px, bool rough) const {
    const StepSd sd = step_sd();
    if (rough) {
      if (step_ - sd.by_depth * offset_ < -kRough * sd.moving) return std::nullopt;
      return 0.0;
    }
    if (step_ < -sd.fixed) return std::nullopt;
    if (step_ > sd.fixed) return 0.0;
    if (root_ <= 0.0) return std::nullopt;
    return window_px * std::pow((sd.fixed - step_) / root_, 2);
  }

  SectorEdge edge() const {
    SectorEdge edge;
    if (!(depth_depth_ > 0.0)) return edge;
    const double sigma_sigma =
        step_ * step_ * of(2, 2) + 2 * step_ * root_ * of(2, 3) + root_ * root_ * of(3, 3);
    const double depth_sigma =
        step_ * step_ * of(0, 2) + step_ * root_ * (of(0, 3) + of(1, 2)) + root_ * root_ * of(1, 3);
    const double sigma_light = step_ * of(2, 4) + root_ * of(3, 4);
    edge.usable = true;
    edge.offset_px = offset_;
    edge.sd_px = std::sqrt(noise2_ / depth_depth_);
    const double sigma_left = sigma_sigma - depth_sigma * depth_sigma / depth_depth_;
    edge.sigma_weight = std::max(0.0, sigma_left) / noise2_;
    edge.offset_by_sigma = -depth_sigma / depth_depth_;
    edge.sigma_change = (sigma_light - depth_sigma * edge.offset_px) / noise2_;
    return edge;
  }

 private:
  double of(std::size_t i, std::size_t j) const {
    return normal_.m[first_ + std::max(i, j)][first_ + std::min(i, j)];
  }

  struct StepSd {
    double fixed = 0.0;     ///< of the step's size, the outline given
    double moving = 0.0;    ///< where the outline is not
    double by_depth = 0.0;  ///< change of the size as the outline moves out
  };
  StepSd step_sd() const {
    std::array<double, kMaxLinear> unit{};
    double variance = 0.0, shared = 0.0;
    for (std::size_t i = kStep; i < first_; ++i) {
      double sum = i == kStep ? 1.0 : 0.0;
      for (std::size_t k = kStep; k < i; ++k) sum -= normal_.m[i][k] * unit[k];
      unit[i] = sum / normal_.m[i][i];
      variance += unit[i] * unit[i];
      shared += unit[i] * (step_ * normal_.m[first_][i] + root_ * normal_.m[first_ + 1][i]);
    }
    return {std::sqrt(noise2_ * variance), std::sqrt(noise2_ * (variance + shared * shared / depth_depth_)),
            shared};
  }

  const Normal& normal_;
  std::size_t first_;
  double step_ = 0.0, root_ = 0.0, depth_depth_ = 0.0, noise2_ = 0.0, offset_ = 0.0;
};

/// One sampled place.
struct Sample {
  float light = 0.0F;
  bool present = false, saturated = false;
};

class Sampler {
 public:
  explicit Sampler(const Photograph& photograph)
      : first_(photograph.light.ptr<float>()),
        row_(static_cast<std::ptrdiff_t>(photograph.light.step1())),
        right_(photograph.width() - 1),
        bottom_(photograph.height() - 1),
        full_(static_cast<float>(0.985 * photograph.saturation)) {}

  Sample at(cv::Point2d image) const {
    if (!(image.x >= 0.0 && image.y >= 0.0 && image.x < right_ && image.y < bottom_)) return {};
    const int x = static_cast<int>(image.x), y = static_cast<int>(image.y);
    const float* above = first_ + static_cast<std::ptrdiff_t>(y) * row_ + x;
    const float* below = above + row_;
    const auto u = static_cast<float>(image.x - x), v = static_cast<float>(image.y - y);
    const float top = above[0] + u * (above[1] - above[0]), bottom = below[0] + u * (below[1] - below[0]);
    const float most = std::max(std::max(above[0], above[1]), std::max(below[0], below[1]));
    return {top + v * (bottom - top), true, most >= full_};
  }

 private:
  const float* first_;
  std::ptrdiff_t row_;
  double right_, bottom_;
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
  step_ = std::max(across / (kMaxDepths - 1), std::min(1.0, across / 20.0));
  depths_ = std::min(kMaxDepths, static_cast<int>(across / step_) + 1);
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
    const cv::Point2d along = frame.is_uncalibrated() ? cv::Point2d(-out.x, out.y) * step_ : cv::Point2d();
    for (int k = 0; k < depths_; ++k) {
      const Sample one = sampler.at(frame.is_uncalibrated() ? from + static_cast<double>(k) * along
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
                      std::span<const OutlineShape> neighbours, const ProfileTable& profiles, double sigma_px,
                      bool rough) {
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
  const Rest rest(normal, spare);
  const auto no_edge = rest.unlit_depth(light.window_px(), rough);
  if (!no_edge || !(rest.step() + rest.root() * profiles.at(2.0 * sigma_px).root > 0.0)) {
    SectorEdge none;
    none.no_edge = true;
    return none;
  }
  SectorEdge edge = rest.edge();
  edge.sd_px = std::hypot(edge.sd_px, *no_edge);
  const double rounding = std::max(0.0, rest.root()) * std::sqrt(sigma_px / light.window_px());
  edge.fading = rounding / std::max(rest.step(), 1e-3 * rounding);
  return edge;
}

}  // namespace strobe::digitize
