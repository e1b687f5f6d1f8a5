// An image that no flash made, among those of a flight: found by what the others say of the flashes without it.
// Source: leave-one-out consistency, as of receiver autonomous integrity monitoring (Brown, 1992).
// No I/O; thread-safe; allocates.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "host/assembly/flash_match.hpp"

namespace strobe::host {

struct FalseImage {
  std::size_t image = 0;  ///< of the track
  FlashMatch match;       ///< of the other images, in the track's order
};

/// The image without which the noise as stated explains the flight, where it does not with it, and without
/// which the others have other times. An image that is only misplaced leaves the others' times as they are: it is the
/// reduction's to leave out. Returns nullopt where there is none; three images of a leg in the air are kept.
std::optional<FalseImage> find_false_image(std::span<const double> times_s, const Track& track,
                                           const std::optional<ArrivalPrior>& prior, const FlashMatch& match);

}  // namespace strobe::host
