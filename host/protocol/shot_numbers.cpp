#include "host/protocol/shot_numbers.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <optional>

#include "common/flight/aerodynamics.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/config/notes.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::protocol {
namespace {

using reduction::kQuantityCount;
using reduction::Quantity;
using Effects = std::array<double, kQuantityCount>;

bool is_of_the_air(reduction::Source source) { return source >= reduction::Source::drag; }

std::string shared_identity(const reduction::BudgetSource& source, const host::Shot& shot) {
  const std::string whose = is_of_the_air(source.source)               ? ""
                            : reduction::is_calibration(source.source) ? shot.calibration
                                                                       : shot.ball;
  return fmt::format("{} {}\n{}", static_cast<int>(source.source), source.number, whose);
}

Sources::Source shared_source(const reduction::BudgetSource& source) {
  // The map's errors are many, and none of them means anything to a person: one line.
  if (source.source == reduction::Source::map)
    return {"map from photograph to plane", source.type, true, 0.0, "", -1};
  return {name_of(source), source.type, true, source.input_sd, std::string(source.input_unit), -1};
}

/// Eigenvectors of the covariance of the numbers over their own sds, which have no unit.
std::vector<Effects> independent_effects(const reduction::Budget& budget) {
  constexpr auto kNumbers = static_cast<Eigen::Index>(kQuantityCount);
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Zero(kNumbers, kNumbers);
  Effects sds{};
  for (std::size_t i = 0; i < kQuantityCount; ++i) sds[i] = std::sqrt(budget.own_covariance[i][i]);
  for (std::size_t i = 0; i < kQuantityCount; ++i)
    for (std::size_t k = 0; k < kQuantityCount; ++k)
      if (sds[i] > 0.0 && sds[k] > 0.0)
        correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
            budget.own_covariance[i][k] / (sds[i] * sds[k]);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(correlation);
  std::vector<Effects> effects;
  for (Eigen::Index j = 0; j < kNumbers; ++j) {
    if (!(solver.eigenvalues()[j] > 1e-12)) continue;  // rounding: sixteen numbers follow from eight
    Effects& one = effects.emplace_back();
    for (std::size_t i = 0; i < kQuantityCount; ++i)
      one[i] = sds[i] * std::sqrt(solver.eigenvalues()[j]) *
               solver.eigenvectors()(static_cast<Eigen::Index>(i), j);
  }
  return effects;
}

}  // namespace

const std::vector<Effects>& ShotNumbers::own_effects(const host::Shot& shot) {
  const auto [found, is_new] = own_.try_emplace(&shot);
  if (is_new) found->second = independent_effects(shot.budget);
  return found->second;
}

Result<Number> ShotNumbers::quantity(const host::Shot& shot, Quantity q) {
  const auto& value = shot.readout.value[q];
  if (!value) return fail(fmt::format("shot {} has no {}", shot.full_name(), name(q)));
  if (shot.budget.sources.empty())
    return fail(fmt::format("shot {} came without its uncertainty", shot.full_name()));
  Number number{*value};
  for (const reduction::BudgetSource& source : shot.budget.sources)
    if (is_shared(source.source) && source.of(q) != 0.0)
      number.effects[sources_.find(shared_identity(source, shot), shared_source(source))] = source.of(q);
  Sources::Source own{"measurement of the shot", host::EvaluationType::b};
  if (const auto& freedom = shot.readout.degrees_of_freedom[q]; freedom && *freedom > 0.0) {
    own.type = host::EvaluationType::a;
    own.group = sources_.group("measurement\n" + shot.full_name(), *freedom);
  }
  const std::vector<Effects>& effects = own_effects(shot);
  for (std::size_t j = 0; j < effects.size(); ++j) {
    const double effect = effects[j][static_cast<std::size_t>(q)];
    if (effect != 0.0)
      number.effects[sources_.find(fmt::format("own {}\n{}", j, shot.full_name()), own)] = effect;
  }
  return number;
}

Result<Number> ShotNumbers::input(const host::Shot& shot, const Input& input) {
  auto value = host::note_number(shot.readout.record, input.name);
  if (!value) value = input.value;
  if (!value)
    return fail(fmt::format("shot {} has no note {} ({})", shot.full_name(), input.name, input.words));
  Number number{*value};
  if (input.sd > 0.0)
    number.effects[sources_.find("input\n" + input.name, {input.words, host::EvaluationType::b, true,
                                                          input.sd, input.unit, -1})] = input.sd;
  return number;
}

Result<BallDrag> ShotNumbers::drag(const host::Shot& shot) {
  if (!shot.rig) return fail(fmt::format("shot {} came without its rig file", shot.full_name()));
  const host::BallSettings& settings = shot.rig->ball;
  const double temperature_c = host::note_number(shot.readout.record, "temperature_c").value_or(20.0);
  const flight::AirLaw law = settings.air_law();
  BallDrag drag{
      flight::aerodynamics(settings.ball(), flight::air_density_kgpm3(temperature_c), {}, law).drag_per_m};
  const double share = law.drag_share_sd();
  const reduction::BudgetSource source{
      .source = reduction::Source::drag, .input_sd = 100.0 * share, .input_unit = "%"};
  drag.error.effects[sources_.find(shared_identity(source, shot), shared_source(source))] = share;
  return drag;
}

}  // namespace strobe::protocol
