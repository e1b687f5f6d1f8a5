// How `strobe predict --tolerance --deadline-us` chooses: among the measured impact models the cheapest that
// meets both, then checked on this very impact by a more exact one where the deadline leaves time for it.
// The error is against the contact's mechanics (ode), as the vector (vx, vy, R omega) at lift-off over the
// speed of touchdown; what a method is relied on for is the largest error over all the contacts measured.
// Every model gets the same material: mu and alpha, where not given, are those of the contact's mechanics.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/frontier/frontier.hpp"
#include "host/commands/predict/predict_model.hpp"

namespace strobe::host {

/// The measured methods that predict can run, and what they were measured over.
struct MeasuredImpacts {
  std::vector<frontier::Row> rows;
  std::vector<frontier::Range> ranges;
};

MeasuredImpacts impacts_of(const std::vector<frontier::Row>& rows,
                           const std::vector<frontier::Range>& ranges);

/// One method as run, or as looked at.
struct TriedImpact {
  frontier::Row row;
  std::optional<double> error_estimate;  ///< of this impact, by `checked_by`; none: no time for a check
  std::optional<frontier::Row> checked_by;
};

struct ImpactChoice {
  TriedImpact taken;
  Prediction prediction;
  PredictInput input;                    ///< with the model and its parameter as chosen
  std::string reason;                    ///< part of a sentence
  std::vector<std::string> outside;      ///< quantities beyond those measured
  std::vector<TriedImpact> replaced;     ///< whose check showed an error beyond the tolerance here
  double expected_cost_us = 0.0;         ///< of all that was run
  std::int64_t took_ns = 0;              ///< what it took, on the clock given: code and data not yet at hand
  std::int64_t took_again_ns = 0;        ///< the same once more
  std::optional<bool> within_tolerance;  ///< as far as checked; none: not checked, or no tolerance
};

/// Input with which to run a row; absent: not a method of predict's, or its parameter says nothing.
std::optional<PredictInput> input_for(const frontier::Row& row, PredictInput in);

/// Among the methods of `model` (empty: of any). Fails with the refusal or with what is wrong with the
/// impact, as one line. `now_ns` is a clock to time the models by; nothing else depends on it.
Result<ImpactChoice> choose_impact(const MeasuredImpacts& measured, const frontier::Demand& demand,
                                   const std::string& model, PredictInput in, std::int64_t (*now_ns)());

}  // namespace strobe::host
