// Puts the images of a frame in order of time, with their legs and, if the flashes are known, their times.
// Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "host/digitize/core/types.hpp"

namespace strobe::digitize {

struct OrderSettings {
  double ball_diameter_m = 0.0651;        ///< > 0
  std::optional<bool> leftwards;          ///< known direction of flight
  std::span<const double> flash_times_s;  ///< ascending; empty: not known
  std::optional<int>
      bounce;  ///< of several, whose legs and times are wanted, from 1; absent: see path_order.hpp
};

/// Orders images and their outlines (as many) by the centres and the frame's surface line, if it has one. A
/// leg that an image already has is kept. Sets time_s and flash_index from the flashes; times are
/// not-a-number without them, with fewer flashes than images, or if no steady flight passes through the
/// images. Assumptions are added to `remarks`.
void order_images(reduction::Frame& frame, std::vector<Outline>& outlines, const OrderSettings& settings,
                  std::vector<std::string>& remarks);

}  // namespace strobe::digitize
