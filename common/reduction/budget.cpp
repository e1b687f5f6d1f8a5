#include "common/reduction/budget.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/reduction/budget_inputs.hpp"
#include "common/reduction/observations.hpp"
#include "common/reduction/reduced_shot.hpp"

namespace strobe::reduction {
namespace {

/// Of an input's sd: the fit ends within a millionth of an sd, which is then a hundred-thousandth of an effect, and what
/// is not linear in a tenth of an sd cancels to the third order.
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

/// The fit ends within a millionth of an sd: differences below this share of the number's own sd are rounding.
constexpr double kNoEffect = 1e-5;

void drop_rounding(const Readout& readout, BudgetSource& source) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const double sd = std::hypot(readout.sd[q].value_or(0.0), readout.sd_systematic[q].value_or(0.0));
    if (std::abs(source.effect[i]) < kNoEffect * sd) source.effect[i] = 0.0;
  }
}

bool has_effect(const BudgetSource& source) {
  return std::ranges::any_of(source.effect, [](double e) { return e != 0.0; });
}

}  // namespace

double Budget::combined_sd(Quantity q) const {
  double sd = 0.0;
  for (const BudgetSource& s : sources) sd = std::hypot(sd, s.of(q));
  return sd;
}

std::optional<double> Budget::degrees_of_freedom(Quantity q) const {
  struct Part {
    double square = 0.0, freedom = 0.0;
  };
  std::map<int, Part>
      estimated;  // by factor: what one estimate makes of several sources goes up and down together
  double all = 0.0;
  for (const BudgetSource& s : sources) {
    const double square = s.of(q) * s.of(q);
    all += square;
    if (!s.degrees_of_freedom) continue;
    Part& part = estimated[s.factor];
    part.square += square;
    part.freedom = *s.degrees_of_freedom;
  }
  double uncertain = 0.0;
  for (const auto& [factor, part] : estimated) {
    if (part.square > 0.0) uncertain += part.square / all * (part.square / all) / part.freedom;
  }
  return uncertain > 0.0 ? std::optional(1.0 / uncertain) : std::nullopt;
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
    for (std::size_t i = 0; i < kQuantityCount; ++i)
      source.effect[i] = source.input_sd > 0.0 ? by_one[i] : std::hypot(source.effect[i], by_one[i]);
  }
  for (BudgetSource& source : budget.sources) drop_rounding(shot->readout, source);
  std::erase_if(budget.sources, [](const BudgetSource& s) { return !has_effect(s); });
  return budget;
}

}  // namespace strobe::reduction
