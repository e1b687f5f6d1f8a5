// The frame that one shot will give, as far as it can be foretold: images at their places and times, with the
// noise that they will have stated, but without error. Thread-safe; deterministic; allocates.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "common/shot/shot_plan.hpp"
#include "host/design/expected_ball.hpp"
#include "host/design/set_up.hpp"

namespace strobe::host {

/// The flashes of a shot and when the ball is expected among them.
struct ExpectedTrain {
  std::vector<double> flash_s;  ///< ascending, from the train's first instant
  double touchdown_s = 0.0;     ///< on the same axis, of a ball with the mean lag
  double arrival_sd_s = 0.0;    ///< of touchdown about it

  bool operator==(const ExpectedTrain&) const = default;
};

/// Of a plan as the rig plays it: free, touchdown is expected at impact_at; gated, as long after the gate as
/// a ball of that speed takes.
ExpectedTrain expected_train(const ShotPlan& plan, const SetUp& set_up, const ExpectedBall& ball);

struct ExpectedShot {
  reduction::Frame frame;
  int incoming = 0, rebound = 0;  ///< images
  double largest_overlap = 0.0;   ///< share of an image's outline that lies within others
  int most_at_one_place = 0;      ///< images that lie on one place, itself included; 0: there is none
  /// Why the noise of its images cannot be foretold; empty: it can.
  std::string not_known;
};

/// Images whose disc lies whole in the photograph, in the air; what the digitizer is not expected to find is
/// left out. `spot` and `arrival` in standard deviations.
ExpectedShot expected_shot(const BallCourse& course, const BallDraw& draw, const ExpectedTrain& train,
                           const ExpectedBall& ball, const SetUp& set_up);

/// The frame as one measurement of it will be: all that it states the noise of is displaced by a draw of it.
reduction::Frame with_noise(reduction::Frame frame, std::uint64_t seed);

}  // namespace strobe::host
