// Record of one opening of the shutter, from which the photograph and the truth are made.
// Plain values, thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <boost/container/static_vector.hpp>
#include <optional>
#include <vector>

#include "common/units/time.hpp"
#include "sim/motion/ball_path.hpp"

namespace strobe::sim {

/// Instants of one pulse: two lamps, each of which may by a fault flash twice.
using FlashTimes = boost::container::static_vector<MonoTime, 4>;

/// One strobe pulse of the firmware (both lamps' lines) and the flashes that it made.
struct Pulse {
  MonoTime edge;               ///< first of the two lines' rising edges
  FlashTimes flashes;          ///< true instants, of both lamps, in no order; empty if neither flashed
  FlashTimes stamps;           ///< of each flash the edge of its lamp's sensor; kNoTime: it gave none
  std::array<int, 2> lamps{};  ///< how many of the flashes are lamp A's, and lamp B's
};

/// Mean of the pulse's flashes; kNoTime if it made none.
MonoTime flash_time(const Pulse& pulse);

struct ThrownBall {
  BallPath path;
  MonoTime touchdown;
  MonoTime released = MonoTime::min();  ///< from a hand; there is no path before
};

struct Exposure {
  int shot = 0;  ///< 1-based
  MonoTime line_on;
  MonoTime opened = kNoTime;  ///< kNoTime: the line was released before the shutter moved
  MonoTime closed = kNoTime;
  std::vector<Pulse> pulses;
  std::optional<ThrownBall> ball;      ///< the one that meets the plate
  std::vector<ThrownBall> more_balls;  ///< that a fault throws besides
  int throws = 0;                      ///< number of the machine's throws for this shot
  std::vector<FaultKind> faults;       ///< that occurred, each once
  bool overrun = false;  ///< the simulation itself could not keep up: edges came late or were lost

  bool has(FaultKind fault) const { return std::ranges::find(faults, fault) != faults.end(); }
};

/// The pulse's number counted from the touchdown: -1 is the last before, 1 the first after. Returns nullopt
/// without a ball.
std::optional<int> place_from_impact(const Exposure& exposure, std::size_t pulse);

/// Whether the ball met the plate while the shutter was open.
bool shows_impact(const Exposure& exposure);

/// One image of the ball on the photograph.
struct FilmImage {
  int pulse = 0;             ///< index into Exposure::pulses
  MonoTime time;             ///< mean of the flashes that it was made of
  MonoTime stamp = kNoTime;  ///< mean of their sensors' edges; kNoTime: no sensor gave one
  BallState state;           ///< mean over the time that the flash gives light, which is from `time` on
};

/// All images in order of time. Flashes less than half a millisecond apart blend into one image (some 8 mm of
/// a fast ball's way), which is measured in its middle. A flash begins at its instant, where the sensor sees
/// it, and gives even light for the scene's flash_s. Where the ball would have met the surface once more
/// than is simulated there is no image.
std::vector<FilmImage> film_images(const Scene& scene, const Exposure& exposure);

}  // namespace strobe::sim
