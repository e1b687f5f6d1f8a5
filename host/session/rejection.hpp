// Which readouts count in a series, and the flags in words. No I/O; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/reduction/readout.hpp"

namespace strobe::host {

/// A flag as a sentence for a person.
std::string_view words(reduction::Flag flag);

/// Why the shot does not count and is fired again, in words. Returns nullopt if it counts. A shot is rejected
/// when it was aborted, has no photograph or too few images of the ball, when a flash that shows the ball was
/// late, missing, double or indistinguishable from others, or when its flash times are not plausible.
std::optional<std::string> rejection_reason(const reduction::Readout& readout);

}  // namespace strobe::host
