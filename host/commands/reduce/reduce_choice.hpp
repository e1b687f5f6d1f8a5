// How `strobe reduce --tolerance --deadline-us` chooses an estimator for a frame.
//
// What an estimator is relied on for is its own part of the error: the measured rms error (against the truth,
// of the worst condition and number, in the scales below) less, in squares, that of the best estimator of the
// same study, and no less than on photographs measured finely, where no noise hides a bias. The noise of the
// photograph itself no estimator can mend; where the readout's own stated sd is beyond the tolerance, that is
// said. Scales of an error: the speed of touchdown for speeds and slip, the same over R for spins, one radian
// for angles, 1 for e and mu, the dwell time, the speed times the dwell time for the distance; the court
// pace, which follows from e and mu, is not judged.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/frontier/frontier.hpp"
#include "common/reduction/frame.hpp"
#include "common/reduction/reduce.hpp"

namespace strobe::host {

/// A measured method as reduce() runs it.
struct MeasuredEstimator {
  reduction::Estimator estimator = reduction::Estimator::best;
  reduction::ReduceOptions options;
};

/// Absent: not an estimator, or its parameter says nothing.
std::optional<MeasuredEstimator> estimator_for(const frontier::Row& row);

/// Which frames were measured as this one is: "reduce" (noise stated), "reduce_fine" (stated, and nearer to
/// .02 mm than to .5 mm), "reduce_estimated" (some noise is to be estimated from the shot).
std::string study_for(const reduction::Frame& frame);

/// The largest sd of a readout in its number's scale, of those that have one.
struct LargestSd {
  reduction::Quantity quantity = reduction::Quantity::v_td_mps;
  double share = 0.0;
};
std::optional<LargestSd> largest_sd(const reduction::Readout& readout, double ball_diameter_m);

/// What is asked for: the demand, and what the user left to choose.
struct EstimatorDemand {
  frontier::Demand demand;
  std::string estimator;  ///< "best", "two-point", "legacy"; empty: any
  std::string flight;     ///< "auto", "none", "gravity", "all"; empty: any
};

/// One frame's choice, told beside the readout.
struct EstimatorChoice {
  frontier::Row row;  ///< `error` is its own part
  std::string reason;
  std::optional<LargestSd> noise;
  bool noise_beyond_tolerance = false;
  std::optional<frontier::Row> replaced;  ///< a cheaper one, whose own sd was beyond the tolerance here
  std::vector<std::string> outside;       ///< quantities beyond those measured
  double expected_cost_us = 0.0;          ///< of all that was run
  std::int64_t took_ns = 0;
};

struct ChosenReadout {
  reduction::Readout readout;
  EstimatorChoice choice;
};

/// Chooses for each kind of frame, then reduces frame by frame; frames of more images than were measured are
/// reckoned to cost in proportion. One thread's.
class EstimatorChooser {
 public:
  /// Fails with the refusal if no kind of frame has an estimator that meets the demand. `now_ns` is a clock
  /// to time by; nothing else depends on it.
  static Result<EstimatorChooser> make(const std::vector<frontier::Row>& rows,
                                       std::vector<frontier::Range> ranges, EstimatorDemand demand,
                                       std::int64_t (*now_ns)());

  /// Fails as reduce() does, and with the refusal for this kind of frame.
  Result<ChosenReadout> reduce(const reduction::Frame& frame) const;

  const frontier::Demand& demand() const { return demand_.demand; }

 private:
  struct Kind {
    std::string study;
    std::vector<frontier::Row> rows;
    tl::expected<frontier::Row, frontier::Nearest> chosen;
  };

  const Kind* kind_of(const reduction::Frame& frame) const;
  Kind with_costs_of(Kind kind, const reduction::Frame& frame) const;
  Result<reduction::Readout> timed(const frontier::Row& row, const reduction::Frame& frame,
                                   EstimatorChoice& choice) const;
  std::optional<frontier::Row> better(const Kind& kind, const EstimatorChoice& choice) const;

  EstimatorDemand demand_;
  std::vector<Kind> kinds_;
  std::vector<frontier::Range> ranges_;
  std::int64_t (*now_ns_)() = nullptr;
};

/// As a JSON object, and as lines of text.
std::string choice_json(const EstimatorChoice& choice, const frontier::Demand& demand);
std::vector<std::string> choice_lines(const EstimatorChoice& choice);

}  // namespace strobe::host
