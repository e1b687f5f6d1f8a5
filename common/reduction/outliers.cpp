#include "common/reduction/outliers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/reduction/consistency.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::reduction {
namespace {

/// A residual variance below this share of the measurement's is rounding: the fit must pass through the
/// measurement, which no other can contradict.
constexpr double kRounding = 1e-9;

struct Suspect {
  double probability = 1.0;  // of so large a deviation by chance, times the number, over the weight
  double square = 0.0;       // of the deviation, in variances
  std::size_t image = 0;
  MeasurementKind kind = MeasurementKind::centre;
  bool clear = true;                             // beyond chance as well as the sds are known, too
  bool worse_than(const Suspect& other) const {  // far out no probability is left to compare
    return probability < other.probability || (probability == other.probability && square > other.square);
  }
};

/// What measurements are held against: their stated noise, or for a kind whose residuals exceed that the
/// residuals' own scatter.
struct Yardstick {
  double variance = 1.0;  ///< over the stated one
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};
using Yardsticks = std::array<Yardstick, kMeasurementKindCount>;

using Kinds = std::array<bool, kMeasurementKindCount>;

Yardsticks yardsticks_of(const ShotFit& fit, const Kinds& by_scatter) {
  Yardsticks yardsticks;
  for (std::size_t kind = 0; kind < kMeasurementKindCount; ++kind) {
    if (!by_scatter[kind]) continue;
    const ResidualScatter scatter = scatter_of(fit, static_cast<MeasurementKind>(kind));
    if (scatter.degrees_of_freedom > 0.0 && scatter.sum_of_squares > 0.0)
      yardsticks[kind] = {scatter.sum_of_squares / scatter.degrees_of_freedom, scatter.degrees_of_freedom};
  }
  return yardsticks;
}

/// A photograph's kinds of measurement that are looked at here share its false alarms.
constexpr double kThreshold = kFalseAlarms / 3.0;

/// Beyond chance, in one round.
class Suspects {
 public:
  Suspects(const ShotFit& fit, const Kinds& by_scatter)
      : fit_(fit), yardsticks_(yardsticks_of(fit, by_scatter)) {}

  /// A measurement's squared deviation over its variance; `chances`: how many there are, over its weight.
  void consider(double square, NoiseGroup noise, int dimensions, double chances, std::size_t image,
                MeasurementKind kind);

  std::vector<Suspect> found;

 private:
  const ShotFit& fit_;
  Yardsticks yardsticks_;
};

/// Share of a kind beyond which so many outliers are not to be believed: with more of them the stated noise
/// is wrong.
constexpr double kMaxRejectedShare = 0.25;

/// Of a square with `dimensions` degrees of freedom, in units of a variance that was estimated without it: t
/// squared, or half of F.
double chance_without(double square, double degrees_of_freedom, int dimensions) {
  if (dimensions == 2)  // in closed form
    return std::pow(1.0 + square / degrees_of_freedom, -0.5 * degrees_of_freedom);
  return statistics::student_t_tail(std::sqrt(square), degrees_of_freedom);
}

/// Of a square with `dimensions` degrees of freedom, in units of a variance that was estimated with it
/// included: by the variance without it, F.
double chance_of_square(double square, double degrees_of_freedom, int dimensions) {
  if (!std::isfinite(degrees_of_freedom)) {
    return dimensions == 2 ? std::exp(-0.5 * square) : std::erfc(std::sqrt(0.5 * square));
  }
  const double left = degrees_of_freedom - dimensions;
  if (left < 0.5) return 1.0;
  const double rest = (degrees_of_freedom - square) / left;
  return rest > 0.0 ? chance_without(square / rest, left, dimensions) : 0.0;
}

void Suspects::consider(double square, NoiseGroup noise, int dimensions, double chances, std::size_t image,
                        MeasurementKind kind) {
  if (square < (dimensions == 2 ? 9.0 : 4.0)) return;  // cannot be beyond chance
  Yardstick yardstick = yardsticks_[static_cast<std::size_t>(kind)];
  if (noise != NoiseGroup::stated)
    yardstick.degrees_of_freedom =
        fit_.variance_components[static_cast<std::size_t>(noise)].degrees_of_freedom;
  const double chance =
      chance_of_square(square / yardstick.variance, yardstick.degrees_of_freedom, dimensions);
  if (!(chance * chances < kThreshold)) return;
  const bool as_stated = yardstick.variance == 1.0 && !std::isfinite(yardstick.degrees_of_freedom);
  const bool doubtful = as_stated && fit_.observations.images[image].digitized &&
                        chance_without(square, kDigitizersFreedom, dimensions) * chances >= kThreshold;
  found.push_back({chance * chances, square, image, kind, !doubtful});
}

/// Squared deviation from the prediction by the other images: the whitened residual r has covariance I - H,
/// H being the share that the image has in its own fitted place.
double deleted_square(const ShotFit& fit, const geometry::Rotation2d& tilt, const Observation& o) {
  const ImageRows rows = image_rows(fit.observations, fit.joint, tilt, o);
  const auto x = fit.joint.factor.whitened(leg_index(*o.leg), rows.row[0]);
  const auto y = fit.joint.factor.whitened(leg_index(*o.leg), rows.row[1]);
  const double xx = 1.0 - dot(x, x);
  const double xy = -dot(x, y);
  const double yy = 1.0 - dot(y, y);
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > kRounding) || !(xx > kRounding)) return 0.0;
  const double rx = rows.residual[0];
  const double ry = rows.residual[1];
  return (yy * rx * rx - 2.0 * xy * rx * ry + xx * ry * ry) / determinant;
}

/// Of a ball's own images, too, one in a hundred has a wrong centre, by an arc of another one say, which no
/// probability of being a ball tells: 16 of 1073 on rendered photographs, crowded, noisy, blurred and dim
/// ones, are beyond 4.5 sd.
constexpr double kWrongOfBalls = 0.01;

/// Shares of the false alarms among the centres that are tested, their mean 1, so that all together stay as
/// frequent: as likely as one is wrong, by the probability that its image is a ball's. Diameters have none,
/// as that probability was told by them, too. Where all are equally probable, or none is stated, exactly 1.
/// Source: Genovese, Roeder & Wasserman, False discovery control with p-value weighting, Biometrika 93
/// (2006).
class Weights {
 public:
  Weights(const std::vector<Observation>& images, const std::vector<std::size_t>& tested) {
    for (const std::size_t i : tested) {
      if (images[i].probability) largest_ = std::max(largest_, wrong(*images[i].probability));
    }
    for (const std::size_t i : tested) {
      if (!images[i].probability) continue;
      sum_ += wrong(*images[i].probability) / largest_;
      count_ += 1.0;
    }
  }

  double of(const Observation& o) const {
    return o.probability ? wrong(*o.probability) / largest_ * count_ / sum_ : 1.0;
  }

 private:
  static double wrong(double probability) { return 1.0 - probability * (1.0 - kWrongOfBalls); }

  double largest_ = 0.0, sum_ = 0.0, count_ = 0.0;
};

void suspect_centres(const ShotFit& fit, Suspects& suspects) {
  const std::vector<Observation>& images = fit.observations.images;
  const geometry::Rotation2d tilt = tilt_of(fit.joint);
  int count[2] = {0, 0};
  for (const Observation& o : images) {
    if (o.use_centre) ++count[leg_index(*o.leg)];
  }
  std::vector<std::size_t> tested;
  tested.reserve(images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].use_centre && count[leg_index(*images[i].leg)] >= kMinForOutlier) tested.push_back(i);
  }
  const Weights weights(images, tested);
  for (const std::size_t i : tested) {
    const double chances = (count[0] + count[1]) / weights.of(images[i]);
    suspects.consider(deleted_square(fit, tilt, images[i]), images[i].centre_noise, 2, chances, i,
                      MeasurementKind::centre);
  }
}

void suspect_diameters(const ShotFit& fit, Suspects& suspects) {
  const MeanDiameter diameters = mean_diameter(fit);
  if (diameters.count < kMinForOutlier) return;
  for (std::size_t i = 0; i < fit.observations.images.size(); ++i) {
    const Observation& o = fit.observations.images[i];
    if (!o.use_diameter) continue;
    const double residual = o.diameter_m - diameters.mean_m;
    const double sd = fit.observations.diameter_sd(o);
    const double variance = sd * sd - 1.0 / diameters.weight;
    const double square = variance > kRounding * sd * sd ? residual * residual / variance : 0.0;
    suspects.consider(square, o.diameter_noise, 1, diameters.count, i, MeasurementKind::diameter);
  }
}

void suspect_equators(const ShotFit& fit, Suspects& suspects) {
  const double chances = static_cast<double>(fit.equators[0].size() + fit.equators[1].size());
  for (std::size_t leg = 0; leg < 2; ++leg) {
    const auto& readings = fit.equators[leg];
    if (!fit.spin[leg] || readings.size() < static_cast<std::size_t>(kMinForOutlier)) continue;
    for (std::size_t i = 0; i < readings.size(); ++i) {
      const double by_time = fit.spin[leg]->omega_radps * readings[i].time_sd_s;
      const double noise = readings[i].sd_rad * readings[i].sd_rad + by_time * by_time;
      const double variance = noise * (1.0 - fit.spin[leg]->leverage[i]);
      const double residual = fit.spin[leg]->residual_rad[i];
      const double square = variance > kRounding * noise ? residual * residual / variance : 0.0;
      const NoiseGroup group = readings[i].estimated_noise ? NoiseGroup::equator : NoiseGroup::stated;
      suspects.consider(square, group, 1, chances, readings[i].index, MeasurementKind::equator);
    }
  }
}

/// A measurement left out, with what was used of its image before.
struct LeftOut {
  std::size_t image = 0;
  MeasurementKind kind = MeasurementKind::centre;
  bool use_centre = false, use_diameter = false, use_equator = false;
  double square = 0.0;  // of the deviation, in variances
  bool clear = true;
};

class Rejection {
 public:
  Rejection(ShotFit& fit, const std::function<void()>& fit_again) : fit_(fit), fit_again_(fit_again) {
    for (const Observation& o : fit.observations.images) {
      largest_probability_ = std::max(largest_probability_, o.probability.value_or(1.0));
      most_[static_cast<std::size_t>(MeasurementKind::centre)] += o.use_centre ? kMaxRejectedShare : 0.0;
      most_[static_cast<std::size_t>(MeasurementKind::diameter)] += o.use_diameter ? kMaxRejectedShare : 0.0;
      most_[static_cast<std::size_t>(MeasurementKind::equator)] += o.use_equator ? kMaxRejectedShare : 0.0;
    }
  }

  Contradiction contradiction() const {
    if (left_out_.empty()) return Contradiction::none;
    return std::ranges::any_of(left_out_, &LeftOut::clear) ? Contradiction::clear : Contradiction::doubtful;
  }
  bool too_many(std::size_t kind) const { return count_[kind] > most_[kind]; }

  /// Kinds whose noise rather than whose measurements may be wrong: too many had to go, or what is left of
  /// them, or of all kinds together, still scatters as one in a hundred would by chance and what was left out
  /// is not far beyond that.
  Kinds doubted() const {
    constexpr double kWellExplained = 0.01;
    const auto explained = [](const ResidualScatter& rest) {
      constexpr double kKnown = std::numeric_limits<double>::infinity();
      return chance_of_scatter(rest.sum_of_squares, rest.degrees_of_freedom, kKnown) >= kWellExplained;
    };
    ResidualScatter all;
    Kinds doubted{};
    for (std::size_t kind = 0; kind < kMeasurementKindCount; ++kind) {
      const ResidualScatter rest = scatter_of(fit_, static_cast<MeasurementKind>(kind));
      all.sum_of_squares += rest.sum_of_squares;
      all.degrees_of_freedom += rest.degrees_of_freedom;
      doubted[kind] = !explained(rest);
    }
    const bool all_explained = explained(all);
    for (std::size_t kind = 0; kind < kMeasurementKindCount; ++kind)
      doubted[kind] =
          too_many(kind) || ((doubted[kind] || !all_explained) &&
                             (near_the_rest(kind, all) ||
                              near_the_rest(kind, scatter_of(fit_, static_cast<MeasurementKind>(kind)))));
    return doubted;
  }

  /// Leaves out the worst until all that are left fit. Returns false if that takes too many of a kind.
  bool converge(const Kinds& by_scatter) {
    for (;;) {
      Suspects suspects(fit_, by_scatter);
      suspect_centres(fit_, suspects);
      suspect_diameters(fit_, suspects);
      suspect_equators(fit_, suspects);
      if (suspects.found.empty()) return true;
      std::ranges::sort(suspects.found, [](const Suspect& a, const Suspect& b) { return a.worse_than(b); });
      leave_out(suspects.found);
      for (std::size_t kind = 0; kind < kMeasurementKindCount; ++kind) {
        if (too_many(kind)) return false;
      }
      fit_again_();
    }
  }

  void restore() {
    for (auto last = left_out_.rbegin(); last != left_out_.rend(); ++last) {
      Observation& o = fit_.observations.images[last->image];
      o.use_centre = last->use_centre;
      o.use_diameter = last->use_diameter;
      o.use_equator = last->use_equator;
    }
    left_out_.clear();
    count_ = {};
    fit_again_();
  }

 private:
  /// Whether something of the kind was left out that is within 6 sd of the rest's scatter. Of 20 degrees of
  /// freedom a variance comes out at less than 0.54 of the true one once in twenty times: further out are 19
  /// variances or more, beyond chance for ten measurements.
  bool near_the_rest(std::size_t kind, const ResidualScatter& rest) const {
    constexpr double kFar = 36.0;
    return std::ranges::any_of(left_out_, [&](const LeftOut& one) {
      return static_cast<std::size_t>(one.kind) == kind &&
             one.square * rest.degrees_of_freedom < kFar * rest.sum_of_squares;
    });
  }

  /// The worst; of many images all that are nearly as bad, for one bad image hardly moves so many.
  void leave_out(const std::vector<Suspect>& suspects) {
    constexpr double kNearly = 0.25;  // of the worst one's square: half as far out
    const std::size_t at_once = 1 + fit_.observations.images.size() / 32;
    for (std::size_t i = 0; i < suspects.size() && i < at_once; ++i) {
      if (suspects[i].square >= kNearly * suspects[0].square) leave_out(suspects[i]);
    }
  }

  void leave_out(const Suspect& suspect) {
    Observation& o = fit_.observations.images[suspect.image];
    left_out_.push_back({suspect.image, suspect.kind, o.use_centre, o.use_diameter, o.use_equator,
                         suspect.square, suspect.clear});
    // An image that the digitizer doubts, too, says the less against the centres' noise.
    count_[static_cast<std::size_t>(suspect.kind)] +=
        suspect.kind == MeasurementKind::centre ? o.probability.value_or(1.0) / largest_probability_ : 1.0;
    if (suspect.kind == MeasurementKind::centre) o.use_centre = o.use_diameter = o.use_equator = false;
    if (suspect.kind == MeasurementKind::diameter) o.use_diameter = false;
    if (suspect.kind == MeasurementKind::equator) o.use_equator = false;
  }

  ShotFit& fit_;
  const std::function<void()>& fit_again_;
  std::vector<LeftOut> left_out_;
  std::array<double, kMeasurementKindCount> most_{};
  std::array<double, kMeasurementKindCount> count_{};
  double largest_probability_ = 0.0;
};

}  // namespace

Contradiction reject_outliers(ShotFit& fit, const std::function<void()>& fit_again) {
  Rejection rejection(fit, fit_again);
  const bool converged = rejection.converge({});
  if (rejection.contradiction() == Contradiction::none) return Contradiction::none;
  const Kinds by_scatter = rejection.doubted();
  if (converged && by_scatter == Kinds{}) return rejection.contradiction();
  rejection.restore();
  if (!rejection.converge(by_scatter)) rejection.restore();
  return rejection.contradiction();
}

}  // namespace strobe::reduction
