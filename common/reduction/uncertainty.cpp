#include "common/reduction/uncertainty.hpp"

#include <algorithm>
#include <boost/random/chi_squared_distribution.hpp>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <limits>
#include <utility>

#include "common/reduction/budget_inputs.hpp"
#include "common/reduction/reduced_shot.hpp"
#include "common/reduction/running_statistics.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::reduction {
namespace {

/// Of an input's sd: the fit ends within a millionth of an sd, which is then a hundred-thousandth of an
/// effect, and what is not linear in a tenth of an sd cancels to the third order.
constexpr double kStep_sd = 0.1;

constexpr std::array<std::string_view, kSourceCount> kNames{"centres",
                                                            "diameters",
                                                            "equators",
                                                            "surface points",
                                                            "flash times",
                                                            "unknown spin",
                                                            "assignment of flashes",
                                                            "scale",
                                                            "map error",
                                                            "ball diameter",
                                                            "all diameters",
                                                            "drag coefficient",
                                                            "lift coefficient, incoming",
                                                            "lift coefficient, rebound",
                                                            "spin decay"};

/// By one standard deviation of the input.
std::array<double, kQuantityCount> effects(const Inputs& inputs, const Input& input,
                                           const PropagationOptions& propagation) {
  const auto moved = [&](double sds) {
    ShotFit fit = inputs.fit;
    input.move(fit, sds);
    return numbers(std::move(fit), propagation);
  };
  const Quantities up = moved(kStep_sd);
  const Quantities down = moved(-kStep_sd);
  std::array<double, kQuantityCount> by_one{};
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    by_one[i] = difference(up[q], down[q]) / (2.0 * kStep_sd);
  }
  return by_one;
}

/// The fit ends within a millionth of an sd: differences below this share of the number's own sd are
/// rounding.
constexpr double kNoEffect = 1e-5;

void drop_rounding(const Readout& readout, BudgetSource& source) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const double sd = std::hypot(readout.sd[q].value_or(0.0), readout.sd_systematic[q].value_or(0.0));
    if (!readout.value[q] || std::abs(source.effect[i]) < kNoEffect * sd) source.effect[i] = 0.0;
  }
}

void add_covariance(const std::array<double, kQuantityCount>& by_one, Budget& budget) {
  for (std::size_t i = 0; i < kQuantityCount; ++i)
    for (std::size_t k = 0; k < kQuantityCount; ++k) budget.own_covariance[i][k] += by_one[i] * by_one[k];
}

bool has_effect(const BudgetSource& source) {
  return std::ranges::any_of(source.effect, [](double e) { return e != 0.0; });
}

constexpr double kOutside = 0.5 * (1.0 - kExpandedLevel);

class Drawing {
 public:
  Drawing(const ShotFit& fit, const PropagationOptions& propagation, std::uint64_t seed)
      : inputs_(inputs_of(fit)), propagation_(propagation), random_(seed) {}

  Quantities draw() {
    boost::random::normal_distribution<double> normal;
    std::array<double, kNoiseGroupCount> widened;
    widened.fill(0.0);  // not drawn yet
    ShotFit moved = inputs_.fit;
    for (const Input& input : inputs_.inputs)
      input.move(moved, normal(random_) * widening(inputs_.sources[input.source], widened));
    return numbers(std::move(moved), propagation_);
  }

 private:
  /// Student's t is a normal deviate over the root of chi squared by its degrees of freedom.
  double widening(const BudgetSource& source, std::array<double, kNoiseGroupCount>& drawn) {
    if (!source.degrees_of_freedom || !(*source.degrees_of_freedom > 0.0)) return 1.0;
    double& factor = drawn[static_cast<std::size_t>(source.factor)];
    if (factor == 0.0) {
      const double freedom = *source.degrees_of_freedom;
      factor = std::sqrt(freedom / boost::random::chi_squared_distribution<double>(freedom)(random_));
    }
    return factor;
  }

  Inputs inputs_;
  PropagationOptions propagation_;
  boost::random::mt19937_64 random_;  ///< the same draws with every standard library
};

/// Of n sorted draws, the end below which `share` of them lie; its sd from the binomial distribution of their
/// number there: half the distance between the draws that far on either side.
struct End {
  double value = 0.0, sd = 0.0;
};

End end_of(const std::vector<double>& sorted, double share) {
  const double n = static_cast<double>(sorted.size());
  const double at = share * (n - 1.0);
  const double reach = std::sqrt(n * share * (1.0 - share));
  const auto draw = [&](double place) {
    return sorted[static_cast<std::size_t>(std::lround(std::clamp(place, 0.0, n - 1.0)))];
  };
  return {draw(at), 0.5 * (draw(at + reach) - draw(at - reach))};
}

/// Half a unit of its last significant digit, if it has so many.
double tolerance_of(double standard_uncertainty, int digits) {
  return 0.5 * std::pow(10.0, std::floor(std::log10(standard_uncertainty)) + 1.0 - digits);
}

Agreement agreement(double off, double tolerance, double end_sd) {
  // Of sixteen quantities chance alone takes one beyond three sds once in some twenty times.
  constexpr double kReach = 3.0;
  if (off + kReach * end_sd <= tolerance) return Agreement::yes;
  return off - kReach * end_sd > tolerance ? Agreement::no : Agreement::open;
}

std::optional<DrawnNumber> summary(std::vector<double>& values, const Readout& readout, Quantity q) {
  const auto expanded = expanded_uncertainty(readout, q);
  if (values.size() < 2 || !readout.value[q] || !expanded) return std::nullopt;
  DrawnNumber number;
  number.draws = static_cast<int>(values.size());
  RunningStatistics all;
  for (const double v : values) all.add(v);
  number.mean = all.mean();
  number.sd = all.population_sd();
  std::ranges::sort(values);
  const End low = end_of(values, kOutside), high = end_of(values, 1.0 - kOutside);
  number.low = low.value;
  number.high = high.value;
  number.end_sd = std::max(low.sd, high.sd);
  const double sd = std::hypot(*readout.sd[q], readout.sd_systematic[q].value_or(0.0));
  if (!(sd > 0.0)) return number;
  const double off = std::max(std::abs(*readout.value[q] - *expanded - number.low),
                              std::abs(*readout.value[q] + *expanded - number.high));
  for (number.digits = 2; number.digits > 0; --number.digits) {
    number.tolerance = tolerance_of(sd, number.digits);
    number.agrees = agreement(off, number.tolerance, number.end_sd);
    if (number.agrees != Agreement::open || number.digits == 1) break;
  }
  return number;
}

}  // namespace

std::optional<double> total_sd(const Numbers& numbers, Quantity quantity) {
  const auto& sd = numbers.sd[quantity];
  if (!sd) return std::nullopt;
  return std::hypot(*sd, numbers.sd_systematic[quantity].value_or(0.0));
}

std::optional<double> expanded_uncertainty(const Numbers& numbers, Quantity quantity) {
  const auto& sd = numbers.sd[quantity];
  if (!sd) return std::nullopt;
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const double freedom = numbers.degrees_of_freedom[quantity].value_or(kInfinite);
  const double noise =
      *sd * statistics::student_t_half_width(kExpandedLevel, freedom) / statistics::student_t_sigma(freedom);
  const double tolerances = numbers.sd_systematic[quantity].value_or(0.0) *
                            statistics::student_t_half_width(kExpandedLevel, kInfinite);
  return std::hypot(noise, tolerances);
}

std::string name_of(const BudgetSource& source) {
  std::string name(kNames[static_cast<std::size_t>(source.source)]);
  if (source.source == Source::unknown_spin) return name + (source.number == 1 ? ", incoming" : ", rebound");
  return source.number > 0 ? name + " " + std::to_string(source.number) : name;
}

Result<Budget> uncertainty_budget(const Frame& frame, Estimator estimator, const ReduceOptions& options,
                                  SourceChoice choice) {
  if (estimator == Estimator::legacy) return fail("the estimator legacy has no uncertainty");
  auto shot = reduce_shot(frame, estimator, options);
  if (!shot) return tl::unexpected(shot.error());
  Budget budget;
  if (!shot->fit) return budget;
  const Inputs inputs = inputs_of(*shot->fit);
  const PropagationOptions propagation{temperature_c(frame)};
  budget.sources = inputs.sources;
  for (const Input& input : inputs.inputs) {
    BudgetSource& source = budget.sources[input.source];
    if (choice == SourceChoice::shared && !is_shared(source.source)) continue;
    const auto by_one = effects(inputs, input, propagation);
    if (!is_shared(source.source)) add_covariance(by_one, budget);
    for (std::size_t i = 0; i < kQuantityCount; ++i)
      source.effect[i] = source.input_sd > 0.0 ? by_one[i] : std::hypot(source.effect[i], by_one[i]);
  }
  for (BudgetSource& source : budget.sources) drop_rounding(shot->readout, source);
  std::erase_if(budget.sources, [](const BudgetSource& s) { return !has_effect(s); });
  return budget;
}

Result<MonteCarlo> monte_carlo(const Frame& frame, int draws, std::uint64_t seed, Estimator estimator,
                               const ReduceOptions& options) {
  if (estimator == Estimator::legacy) return fail("the estimator legacy has no uncertainty");
  if (draws < kMinDraws || draws > kMaxDraws) return fail("draws: must be 1,000 to 10,000,000");
  auto shot = reduce_shot(frame, estimator, options);
  if (!shot) return tl::unexpected(shot.error());
  MonteCarlo result{.draws = draws, .seed = seed};
  if (!shot->fit) return result;
  Drawing drawing(*shot->fit, {temperature_c(frame)}, seed);
  std::array<std::vector<double>, kQuantityCount> values;
  for (int i = 0; i < draws; ++i) {
    const Quantities drawn = drawing.draw();
    for (std::size_t k = 0; k < kQuantityCount; ++k) {
      if (const auto& value = drawn[static_cast<Quantity>(k)]) values[k].push_back(*value);
    }
  }
  for (std::size_t k = 0; k < kQuantityCount; ++k)
    result.quantities[k] = summary(values[k], shot->readout, static_cast<Quantity>(k));
  return result;
}

}  // namespace strobe::reduction
