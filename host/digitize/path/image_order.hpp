// The order of a path's images in time, and the flashes that made them. The incoming leg is the faster one
// along the surface's normal, as a bounce adds no energy. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

struct TimeContext {
  PathContext path;
  double px_per_m = 0.0;
  Eigen::Vector2d gravity_mps2 = Eigen::Vector2d::Zero();  ///< in the axes of the points
  std::optional<bool> leftwards;                           ///< known direction of flight
  std::optional<int> bounce;  ///< whose legs are told, from 1 in time; absent: see path_order.hpp
};

struct TimeOrder {
  std::vector<int> sequence;                       ///< indices of the points, in order of time
  std::vector<std::optional<reduction::Leg>> leg;  ///< of the sequence; absent where undecided
  std::vector<bool> other_leg;  ///< of the sequence: of neither leg of the bounce, or not told of which
  /// Of the sequence: indices into the flashes, -1 for images of other legs. Empty: not known, or no steady
  /// flight passes through the images.
  std::vector<int> flash;
  bool leftwards = false;
  std::vector<std::string> remarks;  ///< assumptions and ambiguities
};

TimeOrder order_in_time(std::span<const PathPoint> points, const Path& path, const TimeContext& context);

// Puts the images of a frame in order of time, with their legs and, if the flashes are known, their times.
// Deterministic; no I/O; thread-safe; allocates.

/// The surface's line as the frame has it; nullopt if it has none.
std::optional<SurfaceLine> surface_line_of(const reduction::Frame& frame);

/// Orders images and their outlines (as many) by the centres and the frame's surface line, if it has one. A
/// leg that an image already has is kept. Sets time_s and flash_index from the flashes; times are
/// not-a-number without them, with fewer flashes than images, or if no steady flight passes through the
/// images. Assumptions are added to `remarks`.
void order_images(reduction::Frame& frame, std::vector<Outline>& outlines, const FlightFacts& facts,
                  std::vector<std::string>& remarks);

}  // namespace strobe::digitize
