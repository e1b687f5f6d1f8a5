// `strobe predict --tolerance --deadline-us`: chooses among the measured impact models the cheapest that
// meets both, then checks it on this impact by a more accurate one if the deadline leaves time. Errors are
// relative to the contact ODE: the vector (vx, vy, R·omega) at lift-off over the speed of touchdown. The first choice
// goes by the largest error over all contacts measured; what is promised is about this impact wherever it can be: the
// difference from a run ten times as accurate plus that run's own error, or the tolerance that the method's own error
// control keeps. All models use the same mu and alpha; where not
// given, those of the contact ODE. Deterministic but for the times; thread-safe; allocates.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/frontier/frontier.hpp"
#include "common/units/time.hpp"
#include "host/commands/predict/predict_model.hpp"

namespace strobe::host {

/// The measured methods that predict can run, and the ranges they were measured over.
struct MeasuredModels {
  std::vector<frontier::Row> rows;
  std::vector<frontier::Range> ranges;
};

MeasuredModels measured_models(const std::vector<frontier::Row>& rows,
                               const std::vector<frontier::Range>& ranges);

/// One method that was run.
struct TriedModel {
  frontier::Row row;
  std::optional<double> error_estimate;  ///< on this impact, against `checked_by`; absent without a check
  std::optional<frontier::Row> checked_by;
};

/// Where a promise comes from.
enum class PromiseBasis {
  check,           ///< a more accurate run of this impact
  error_control,   ///< the method holds itself to its tolerance on this impact
  worst_measured,  ///< the largest error over all contacts measured: nothing is known of this impact
};

constexpr std::string_view name(PromiseBasis basis) {
  constexpr std::array<std::string_view, 3> names{"check", "error_control", "worst_measured"};
  return names[static_cast<std::size_t>(basis)];
}

struct ImpactPromise {
  double error = 0.0;  ///< at most
  PromiseBasis basis = PromiseBasis::worst_measured;
};

struct ImpactChoice {
  TriedModel taken;
  ImpactPromise promise;
  Prediction prediction;
  PredictInput input;                    ///< with the model and its parameter as chosen
  std::string reason;                    ///< part of a sentence
  std::vector<std::string> outside;      ///< quantities beyond those measured
  std::vector<TriedModel> replaced;      ///< methods whose check showed an error beyond the tolerance
  double expected_cost_us = 0.0;         ///< of all runs
  Duration duration{};                   ///< measured, of the first calls (cold caches)
  Duration repeated_duration{};          ///< measured, of the same calls repeated
  std::optional<bool> within_tolerance;  ///< absent without a check or a tolerance
};

/// Input with which to run a row. Returns nullopt if it is not a method of predict or its parameter is not
/// understood.
std::optional<PredictInput> input_for(const frontier::Row& row, PredictInput in);

/// Chooses among the methods of `model` (empty: of all). Fails, with one line, if no method meets the
/// requirement, and on an impact that the models refuse. `now` is the clock for the durations.
Result<ImpactChoice> choose_impact(const MeasuredModels& measured, const frontier::Requirement& requirement,
                                   const std::string& model, PredictInput in, HostTime (*now)());

}  // namespace strobe::host
