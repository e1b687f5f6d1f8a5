// Chooses an estimator for a frame: `strobe reduce --tolerance --deadline-us`.
//
// An estimator is rated by its excess error: sqrt(rms² - best²), where rms is its measured error (against the
// truth, of the worst condition and number, in the scales below) and best that of the best estimator of the
// same study; but at least its excess error on photographs with little noise, where noise does not hide a
// bias. The photograph's own noise no estimator can remove; where the readout's stated sd exceeds the
// tolerance, the choice says so. Scales of an error: the speed of touchdown for speeds and slip, the same
// over R for spins, one radian for angles, 1 for e and mu, the dwell time, the speed times the dwell time for
// the distance; the court pace follows from e and mu and is not rated.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/frontier/frontier.hpp"
#include "common/reduction/frame.hpp"
#include "common/reduction/reduce.hpp"
#include "common/units/time.hpp"

namespace strobe::host {

/// A measured method as reduce() runs it.
struct MeasuredEstimator {
  reduction::Estimator estimator = reduction::Estimator::best;
  reduction::ReduceOptions options;
};

/// Returns nullopt if the row is not an estimator or its parameter is not understood.
std::optional<MeasuredEstimator> estimator_for(const frontier::Row& row);

/// The study whose frames are like this one: "reduce" (noise stated), "reduce_fine" (stated, and nearer to
/// .02 mm than to .5 mm), "reduce_estimated" (some noise is estimated from the shot).
std::string study_for(const reduction::Frame& frame);

/// The largest sd of a readout in its number's scale, of those that have one.
struct LargestSd {
  reduction::Quantity quantity = reduction::Quantity::v_td_mps;
  double share = 0.0;
};
std::optional<LargestSd> largest_sd(const reduction::Readout& readout, double ball_diameter_m);

/// The requirement, and the options that the user fixed.
struct EstimatorRequirement {
  frontier::Requirement requirement;
  std::string estimator;  ///< "best", "two-point", "legacy"; empty: any
  std::string flight;     ///< "auto", "none", "gravity", "all"; empty: any
};

/// The choice for one frame.
struct EstimatorChoice {
  frontier::Row row;  ///< `error` is the excess error
  std::string reason;
  std::optional<LargestSd> noise;
  bool noise_beyond_tolerance = false;
  std::optional<frontier::Row> replaced;  ///< a cheaper one whose sd exceeded the tolerance on this frame
  std::vector<std::string> outside;       ///< quantities beyond those measured
  double expected_cost_us = 0.0;          ///< of all runs
  Duration duration{};
};

struct ChosenReadout {
  reduction::Readout readout;
  EstimatorChoice choice;
};

/// Chooses for each kind of frame, then reduces frame by frame; frames of more images than were measured are
/// assumed to cost in proportion. Not thread-safe.
class EstimatorChooser {
 public:
  /// Fails if no kind of frame has an estimator that meets the requirement. `now` is the clock for the
  /// durations.
  static Result<EstimatorChooser> make(const std::vector<frontier::Row>& rows,
                                       std::vector<frontier::Range> ranges, EstimatorRequirement requirement,
                                       HostTime (*now)());

  /// Fails like reduce(), and if no estimator meets the requirement for this kind of frame.
  Result<ChosenReadout> reduce(const reduction::Frame& frame) const;

  const frontier::Requirement& requirement() const { return requirement_.requirement; }

 private:
  struct Kind {
    std::string study;
    std::vector<frontier::Row> rows;
    tl::expected<frontier::Row, frontier::NearestMethods> chosen;
  };

  const Kind* kind_of(const reduction::Frame& frame) const;
  Kind with_costs_of(Kind kind, const reduction::Frame& frame) const;
  Result<reduction::Readout> timed(const frontier::Row& row, const reduction::Frame& frame,
                                   EstimatorChoice& choice) const;
  std::optional<frontier::Row> better(const Kind& kind, const EstimatorChoice& choice) const;

  EstimatorRequirement requirement_;
  std::vector<Kind> kinds_;
  std::vector<frontier::Range> ranges_;
  HostTime (*now_)() = nullptr;
};

/// A JSON object, and lines of text.
std::string choice_json(const EstimatorChoice& choice, const frontier::Requirement& requirement);
std::vector<std::string> choice_lines(const EstimatorChoice& choice);

}  // namespace strobe::host
