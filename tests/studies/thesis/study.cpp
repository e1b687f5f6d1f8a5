#include "tests/studies/thesis/study.hpp"

#include <algorithm>

#include "common/impact/fit/cross_validation.hpp"

namespace strobe::studies {

using reduction::Quantity;

Result<Predictions> predict_all(const thesis::Data& data, Dashpot dashpot, Vertical vertical) {
  std::vector<impact::ContactObservation> observations;
  for (const thesis::Condition& c : data.conditions) observations.push_back(impact::observation_of(c));
  Predictions out;
  out.dashpot = dashpot;
  out.vertical = vertical;
  for (const char* spin : {"zero", "top", "back"}) {
    auto constants = constants_without(spin, observations, vertical, dashpot);
    if (!constants) return tl::unexpected(constants.error());
    out.constants.push_back(*std::move(constants));
  }
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const impact::ContactObservation& o = observations[i];
    const auto constants = std::ranges::find(out.constants, o.group, &Constants::left_out);
    const auto prediction = predict(o, *constants, vertical);
    if (!prediction) return tl::unexpected(prediction.error());
    out.conditions.push_back(
        {&data.conditions[i], o, &*constants, *prediction, input_spread(o, *constants, vertical)});
    const impact::ContactSummary& s = prediction->contact;
    for (Cell& cell :
         cells_of(data.conditions[i], quantities_of(o.touchdown, s.lift_off, s.dwell_s, s.dwell_distance_m),
                  vertical))
      out.cells.push_back(std::move(cell));
  }
  return out;
}

Result<std::vector<Algebraic>> algebraic_models(const thesis::Data& data) {
  const auto observations = impact::observations_of(data.conditions, impact::Spread::replicate);
  std::vector<Algebraic> out;
  for (const auto model :
       {impact::ReboundModel::slide_roll, impact::ReboundModel::grip, impact::ReboundModel::grip_offset}) {
    const auto validation = impact::leave_one_group_out(observations, impact::default_options(model),
                                                        impact::CrossValidationGroup::spin);
    if (!validation) return fail(impact::message(validation.error(), observations));
    Algebraic one{.model = std::string(impact::name(model)), .cells = {}};
    for (const impact::HeldOutGroup& group : validation->groups) {
      for (std::size_t i = 0; i < group.observations.size(); ++i) {
        const impact::Observation& o = observations[group.observations[i]];
        const impact::Motion& lift_off = group.predicted[i].predicted.lift_off;
        one.cells.push_back(
            {o.name, Quantity::vx_lo_mps, lift_off.vx_mps, o.lift_off.vx_mps, o.lift_off_sd.vx_mps, false});
        one.cells.push_back({o.name, Quantity::omega_lo_radps, lift_off.omega_radps, o.lift_off.omega_radps,
                             o.lift_off_sd.omega_radps, false});
      }
    }
    out.push_back(std::move(one));
  }
  return out;
}

Result<Shots> shoot_all(const Predictions& predictions, int shots, std::uint64_t seed, bool exact) {
  Shots out{.name = exact ? "shots without spread and noise" : "means of shots", .cells = {}};
  for (const PredictedCondition& predicted : predictions.conditions) {
    const auto series = shoot_series(*predicted.condition, predicted.prediction, shots, seed, exact);
    if (!series) return fail(predicted.condition->name() + ": " + series.error().message);
    out.shots += series->shots;
    out.without_readout += series->without_readout;
    for (Cell& cell : cells_of(*predicted.condition, series->mean, predictions.vertical))
      out.cells.push_back(std::move(cell));
  }
  return out;
}

}  // namespace strobe::studies
