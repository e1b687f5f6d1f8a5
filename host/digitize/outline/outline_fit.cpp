#include "host/digitize/outline/outline_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/digitize/core/median.hpp"

namespace strobe::digitize {

namespace {

constexpr int kOutlineUnknowns = 5;
constexpr double kTukey = 4.685;      // 95 % efficient on normal errors
constexpr double kUsefulSd_px = 1.0;  // of a sector's offset
constexpr double kMinSigma_px = 0.35;
constexpr int kFewestEdges = 6;
// What the sectors' scatter cannot show: shading and blur unlike the model pull whole stretches alike. Both
// from painted photographs of balls with many looks (tests/host/digitize/outlines_test.cpp).
constexpr double kUnseen = 1.25;
constexpr double kFloor_px = 0.01;
// Across a blurred edge more of the ball's curved side is seen, whose shading the profile follows the less:
// an error that grows as sigma²/radius (what counts lies sigma deep, and light there goes by depth over
// radius), alike for all of an outline. Rendered photographs show 2 to 3 of it, painted ones less than 1.
constexpr double kMisfit = 1.5;
// The limb's fuzz and shading move all of a photograph's outlines in or out by as much, which no scatter
// shows: .025 px of the radius, over 525 rendered photographs with 25 looks.
constexpr double kLimb_px = 0.025;

using Vector = cv::Vec<double, kOutlineUnknowns>;
using Square = cv::Matx<double, kOutlineUnknowns, kOutlineUnknowns>;

Vector gradient(cv::Point2d out) {
  const double c = out.x, s = out.y;
  return {c, s, 1.0, c * c - s * s, 2.0 * c * s};
}

struct Offsets {
  std::vector<SectorEdge> edges;
  std::vector<double> weight;  ///< 1/px²
  std::vector<double> trust;   ///< Tukey's factor
  std::vector<double> pull;    ///< 1/px², how much a sector's offset still moves the fit (Tukey's psi')
  std::vector<double> common;  ///< px, sd that stretches share
  double extra2 = 0.0;         ///< variance beyond the sectors' own
};

bool useful(const SectorEdge& edge) { return edge.usable && edge.sd_px < kUsefulSd_px; }

/// The variance to be added so that the median of residual²/variance is that of a normal's square.
double extra_variance(const std::vector<SectorEdge>& edges, const std::vector<double>& residual) {
  constexpr double kMedianOfSquare = 0.4549;
  const auto middle = [&](double extra) {
    std::vector<double> ratio;
    for (std::size_t i = 0; i < edges.size(); ++i)
      if (useful(edges[i]))
        ratio.push_back(residual[i] * residual[i] / (edges[i].sd_px * edges[i].sd_px + extra));
    return upper_median(std::move(ratio));
  };
  double low = 1e-6, high = 4.0;
  if (middle(low) <= kMedianOfSquare) return low;
  for (int i = 0; i < 14; ++i) {
    const double half = std::sqrt(low * high);
    (middle(half) > kMedianOfSquare ? low : high) = half;
  }
  return high;
}

/// One outline's fit, step by step.
class Fit {
 public:
  Fit(const SectorLight& light, std::span<const OutlineShape> neighbours, const OutlineFitSettings& settings,
      const OutlineShape& start, double sigma)
      : light_(light),
        neighbours_(neighbours),
        settings_(settings),
        start_radius_(start.radius),
        shape_(start),
        sigma_(sigma) {
    for (int i = 0; i < light.count(); ++i) gradients_.push_back(gradient(light.direction(i)));
    offsets_.edges.resize(gradients_.size());
    offsets_.weight.assign(gradients_.size(), 0.0);
    offsets_.trust = offsets_.pull = offsets_.common = offsets_.weight;
  }

  /// Blur and shape change together (Gauss-Newton).
  bool step(bool rough) {
    measure(rough);
    solve({});
    const double grown = blur_change();
    for (SectorEdge& edge : offsets_.edges) edge.offset_px += edge.offset_by_sigma * grown;
    solve(change_);
    if (used() < kFewestEdges) return false;
    const double most = 2.0 * std::max(sigma_, 0.7);
    sigma_ += grown;
    Vector change = change_;
    const double longest = std::max({std::abs(change[0]), std::abs(change[1]), std::abs(change[2])});
    if (longest > most) change *= most / longest;
    shape_.centre += cv::Point2d(change[0], change[1]);
    shape_.radius += change[2];
    shape_.oval_cos += change[3];
    shape_.oval_sin += change[4];
    return true;
  }

  /// As the last step left it.
  FittedOutline result() const {
    FittedOutline fitted;
    fitted.shape = shape_;
    fitted.sigma_px = sigma_;
    fitted.covariance = covariance();
    fitted.weight = offsets_.trust;
    fitted.scatter_px = std::sqrt(offsets_.extra2);
    summarize(fitted);
    return fitted;
  }

 private:
  int count() const { return light_.count(); }

  int used() const {
    return static_cast<int>(
        std::count_if(offsets_.trust.begin(), offsets_.trust.end(), [](double t) { return t > 0.1; }));
  }

  void measure(bool rough) {
    const double most = 2.0 * std::max(sigma_, 0.7);
    const ProfileTable profiles = sector_profiles(light_, shape_.radius, sigma_);
    for (int i = 0; i < count(); ++i) {
      SectorEdge& edge = offsets_.edges[static_cast<std::size_t>(i)];
      edge = fit_sector(light_, i, shape_, neighbours_, profiles, sigma_, rough);
      edge.offset_px = std::clamp(edge.offset_px, -most, most);
    }
    if (!rough) doubt_the_dark();
  }

  /// Where no lamp reaches, single stretches that rise are something else's, and on either side the limb
  /// fades into the terminator, which lies further in: those stretches err alike.
  void doubt_the_dark() {
    constexpr int kReach = 4;
    const auto at = [&](int i) { return static_cast<std::size_t>((i + count()) % count()); };
    std::vector<bool> dark(offsets_.edges.size());
    for (int i = 0; i < count(); ++i) {
      int no_edge = 0, lit = 0;
      for (int k = -kReach; k <= kReach; ++k) {
        const SectorEdge& edge = offsets_.edges[at(i + k)];
        no_edge += edge.no_edge ? 1 : 0;
        lit += edge.usable ? 1 : 0;
      }
      dark[at(i)] = no_edge > lit && no_edge > kReach;
    }
    offsets_.common.assign(offsets_.edges.size(), 0.0);
    for (int i = 0; i < count(); ++i) {
      SectorEdge& edge = offsets_.edges[at(i)];
      if (!edge.usable) continue;
      if (dark[at(i)]) {
        edge.usable = false;
        continue;
      }
      bool near = false;
      for (int k = -kReach; k <= kReach; ++k) near = near || dark[at(i + k)];
      if (!near) continue;
      const double common = sigma_ * std::min(1.0, edge.fading * edge.fading);
      offsets_.common[at(i)] = common;
      edge.sd_px = std::hypot(edge.sd_px, common);
    }
  }

  double residual(int i, const Vector& change) const {
    const auto at = static_cast<std::size_t>(i);
    return offsets_.edges[at].offset_px - gradients_[at].dot(change);
  }

  /// Iteratively reweighted.
  void solve(const Vector& from) {
    constexpr int kRounds = 5;
    change_ = from;
    for (int round = 0; round < kRounds; ++round) {
      reweight(change_);
      Square normal = prior();
      Vector right = prior_pull();
      for (std::size_t i = 0; i < gradients_.size(); ++i) {
        const double w = offsets_.weight[i];
        if (w == 0.0) continue;
        const Vector& g = gradients_[i];
        for (int a = 0; a < kOutlineUnknowns; ++a) {
          for (int b = 0; b <= a; ++b) normal(a, b) += w * g[a] * g[b];
          right[a] += w * offsets_.edges[i].offset_px * g[a];
        }
      }
      for (int a = 0; a < kOutlineUnknowns; ++a)
        for (int b = a + 1; b < kOutlineUnknowns; ++b) normal(a, b) = normal(b, a);
      change_ = normal.solve(right, cv::DECOMP_CHOLESKY);
    }
  }

  void reweight(const Vector& change) {
    std::vector<double> left(static_cast<std::size_t>(count()));
    for (int i = 0; i < count(); ++i) left[static_cast<std::size_t>(i)] = residual(i, change);
    offsets_.extra2 = extra_variance(offsets_.edges, left);
    for (std::size_t i = 0; i < left.size(); ++i) {
      const SectorEdge& edge = offsets_.edges[i];
      offsets_.weight[i] = offsets_.trust[i] = offsets_.pull[i] = 0.0;
      if (!useful(edge)) continue;
      const double variance = edge.sd_px * edge.sd_px + offsets_.extra2;
      const double z2 = left[i] * left[i] / (variance * kTukey * kTukey);
      if (z2 >= 1.0) continue;
      offsets_.trust[i] = (1.0 - z2) * (1.0 - z2);
      offsets_.weight[i] = offsets_.trust[i] / variance;
      offsets_.pull[i] = (1.0 - z2) * std::max(0.0, 1.0 - 5.0 * z2) / variance;
    }
  }

  double oval_precision() const { return 1.0 / std::pow(settings_.oval_sd * start_radius_, 2); }
  double radius_precision() const {
    return settings_.radius_px && settings_.radius_sd_px
               ? 1.0 / std::pow(std::max(*settings_.radius_sd_px, 1e-3), 2)
               : 0.0;
  }
  Square prior() const {
    Square p = Square::zeros();
    p(0, 0) = p(1, 1) = 1e-6;
    p(2, 2) = 1e-6 + radius_precision();
    p(3, 3) = p(4, 4) = oval_precision();
    return p;
  }
  Vector prior_pull() const {
    const double known = settings_.radius_px ? *settings_.radius_px - shape_.radius : 0.0;
    const cv::Vec2d oval = settings_.oval * start_radius_ - cv::Vec2d(shape_.oval_cos, shape_.oval_sin);
    return {0.0, 0.0, radius_precision() * known, oval_precision() * oval[0], oval_precision() * oval[1]};
  }

  double blur_change() const {
    double change = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < offsets_.edges.size(); ++i) {
      change += offsets_.trust[i] * offsets_.edges[i].sigma_change;
      weight += offsets_.trust[i] * offsets_.edges[i].sigma_weight;
    }
    if (weight <= 0.0) return 0.0;
    const double grown = std::clamp(change / weight, -0.4 * sigma_, 0.4 * sigma_);
    return std::max(kMinSigma_px, sigma_ + grown) - sigma_;
  }

  Square covariance() const {
    // Sectors whose errors go together: felt and seams reach over a few; with more, the
    // estimate falls short, as the fit itself takes up what varies slowly along the outline.
    constexpr int kReach = 3;
    std::vector<Vector> score(static_cast<std::size_t>(count()));
    const Square inverse = sensitivity().inv(cv::DECOMP_CHOLESKY);
    for (int i = 0; i < count(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Vector& g = gradients_[at];
      // A residual is short by what its own sector pulled the fit towards it.
      const double leverage = std::min(0.7, offsets_.weight[at] * g.dot(inverse * g));
      score[at] = offsets_.weight[at] * residual(i, change_) / (1.0 - leverage) * g;
    }
    Square meat = prior();
    for (int i = 0; i < count(); ++i) {
      const Vector& here = score[static_cast<std::size_t>(i)];
      meat += here * here.t();
      for (int lag = 1; lag < kReach; ++lag) {
        const Vector& there = score[static_cast<std::size_t>((i + lag) % count())];
        meat += (1.0 - static_cast<double>(lag) / kReach) * (here * there.t() + there * here.t());
      }
    }
    Square covariance = inverse * meat * inverse * (kUnseen * kUnseen);
    // What stretches share is alike where they are near to each other and not across the ball.
    for (int pattern = 0; pattern < 3; ++pattern) {
      Vector pull{};
      for (std::size_t i = 0; i < gradients_.size(); ++i) {
        const double along = pattern == 0 ? 1.0 : gradients_[i][pattern - 1];
        pull += offsets_.weight[i] * along * offsets_.common[i] * gradients_[i];
      }
      const Vector moved = inverse * pull * (1.0 / std::numbers::sqrt2);
      covariance += moved * moved.t();
    }
    const double misfit = kMisfit * sigma_ * sigma_ / shape_.radius;
    for (int a = 0; a < 3; ++a) covariance(a, a) += kFloor_px * kFloor_px + misfit * misfit;
    covariance(2, 2) += kLimb_px * kLimb_px;
    return covariance;
  }

  Square sensitivity() const {
    Square slope = prior();
    for (int i = 0; i < count(); ++i) {
      const Vector& g = gradients_[static_cast<std::size_t>(i)];
      slope += offsets_.pull[static_cast<std::size_t>(i)] * g * g.t();
    }
    return slope;
  }

  void summarize(FittedOutline& fitted) const {
    double squares = 0.0, trusts = 0.0;
    int seen = 0;
    std::vector<bool> is_seen(static_cast<std::size_t>(count()));
    for (int i = 0; i < count(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      squares += offsets_.trust[at] * std::pow(residual(i, change_), 2);
      trusts += offsets_.trust[at];
      is_seen[at] = offsets_.trust[at] > 0.1;
      seen += is_seen[at] ? 1 : 0;
      fitted.saturated_fraction += (light_.saturated_fraction(i) > 0.3 ? 1.0 : 0.0) / count();
      fitted.outside_fraction += (light_.inside_fraction(i) < 0.5 ? 1.0 : 0.0) / count();
    }
    fitted.visible_fraction = static_cast<double>(seen) / count();
    fitted.rms_px = trusts > 0.0 ? std::sqrt(squares / trusts) : 0.0;
    fitted.seen = arcs(is_seen);
  }

  std::vector<Arc> arcs(const std::vector<bool>& seen) const {
    const double turn = 2.0 * std::numbers::pi;
    const int n = count();
    const auto at = [&](int i) { return seen[static_cast<std::size_t>((i + n) % n)]; };
    if (std::all_of(seen.begin(), seen.end(), [](bool s) { return s; })) return {{0.0, turn}};
    std::vector<Arc> found;
    for (int i = 0; i < n; ++i) {
      if (!at(i) || at(i - 1)) continue;
      int length = 1;
      while (at(i + length)) ++length;
      found.push_back({turn * i / n, turn * length / n});
    }
    return found;
  }

  const SectorLight& light_;
  std::span<const OutlineShape> neighbours_;
  OutlineFitSettings settings_;
  double start_radius_;
  OutlineShape shape_;
  double sigma_;
  Offsets offsets_;
  std::vector<Vector> gradients_;  ///< of the radius by the unknowns, by sector
  Vector change_{};
};

}  // namespace

std::optional<FittedOutline> fit_outline(const Photograph& photograph, const LocalFrame& frame,
                                         const OutlineShape& start, double sigma_px,
                                         std::span<const OutlineShape> neighbours,
                                         const OutlineFitSettings& settings) {
  const int sectors =
      std::clamp(static_cast<int>(2.0 * std::numbers::pi * start.radius / settings.sectors_px), 24, 160);
  const double most = 0.3 * start.radius;
  const double length = 2.0 * std::numbers::pi * start.radius / sectors;
  const SectorGrid grid{sectors, std::max(2, static_cast<int>(length / settings.rays_px + 0.5)),
                        std::min(most, 3.0 * sigma_px + settings.outside_px),
                        std::min(most, 3.0 * sigma_px + settings.inside_px)};
  const SectorLight light(photograph, frame, start, grid);
  Fit fit(light, neighbours, settings, start, sigma_px);
  for (int step = 0; step < settings.steps; ++step)
    if (!fit.step(step < settings.rough_steps)) return std::nullopt;
  return fit.result();
}

void apply_oval_prior(FittedOutline& fitted, cv::Vec2d oval, double sd, double former_sd) {
  constexpr double kClearly2 = 16.0;
  OutlineShape& shape = fitted.shape;
  // What is new of it: precisions and their products with the expected oval add up.
  const double precision = (1.0 / (sd * sd) - 1.0 / (former_sd * former_sd)) / (shape.radius * shape.radius);
  const cv::Vec2d expected = oval * (1.0 / (shape.radius * sd * sd * precision));
  const cv::Vec2d off = expected - cv::Vec2d(shape.oval_cos, shape.oval_sin);
  const Square before = fitted.covariance;
  const cv::Matx22d spread = before.get_minor<2, 2>(3, 3) + cv::Matx22d::eye() * (1.0 / precision);
  if (off.dot(spread.inv() * off) > kClearly2) return;
  const cv::Matx<double, kOutlineUnknowns, 2> gain =
      before.get_minor<kOutlineUnknowns, 2>(0, 3) * spread.inv();
  const cv::Matx<double, kOutlineUnknowns, 1> change = gain * off;
  shape.centre += cv::Point2d(change(0), change(1));
  shape.radius += change(2);
  shape.oval_cos += change(3);
  shape.oval_sin += change(4);
  fitted.covariance = before - gain * before.get_minor<2, kOutlineUnknowns>(3, 0);
}

}  // namespace strobe::digitize
