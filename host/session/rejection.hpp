// Which readouts count in a series, and the flags in words. No I/O; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/reduction/readout.hpp"
#include "host/session/train_report.hpp"

namespace strobe::host {

/// A flag as a sentence for a person.
std::string_view words(reduction::Flag flag);
/// Likewise, with the flashes that it is about: of those that show the ball, where these are known.
std::string words(reduction::Flag flag, const reduction::Readout& readout, const FlashFaults& faults);

/// By how much numbers may differ from one plausible assignment of flashes to images to the next: twice the standard
/// deviation between the hypotheses, which of two equally likely ones is their difference.
struct MatchTolerance {
  double percent =
      1.0;  ///< of the speed at touchdown, of the spin of a ball that rolls with it, of 1 (e, mu, the
            ///< court pace's 100), of 1 rad, of the dwell's own time and distance
  double ball_diameter_m = 0.0651;
};

/// Why the shot does not count and is fired again, in words. Returns nullopt if it counts. A shot is rejected
/// when it was aborted, has no photograph or too few images of the ball, when a flash that shows the ball was
/// missing or double, when its flash times are not plausible, or when it is so uncertain which flashes made the
/// images that some number depends on it by more than the tolerance. A late flash does not reject it: its own time is
/// used.
std::optional<std::string> rejection_reason(const reduction::Readout& readout,
                                            const MatchTolerance& tolerance = {},
                                            const FlashFaults& faults = {});

}  // namespace strobe::host
