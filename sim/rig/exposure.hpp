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
#include "sim/random/draws.hpp"
#include "sim/scene/faults.hpp"
#include "sim/scene/scene.hpp"

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

/// One strobe lamp: a delay, some jitter, a capacitor that must recharge, and faults.
/// Virtual time, no clock; one object per lamp, not thread-safe; allocates only if a fault occurs.
class LampModel {
 public:
  /// `scene` must outlive the lamp.
  LampModel(const Scene& scene, std::uint64_t seed, Lamp lamp) : scene_(scene), seed_(seed), lamp_(lamp) {}

  /// The flashes that a rising edge of the lamp's line makes: one, none, or with a fault two; in order of
  /// time. Kinds of faults that occurred are appended to `occurred`.
  FlashTimes on_pulse(MonoTime edge, const FlashPlace& place, std::vector<FaultKind>& occurred);

  /// Discards earlier flashes and draws.
  void restart() {
    last_flash_ = kNoTime;
    draws_.reset();
  }

  /// Jitter of the sensor's edge for the latest pulse's flashes.
  double sensor_jitter_s() const { return sensor_jitter_s_; }

  /// Whether the sensor that looks at this lamp works in this shot.
  bool sensor_works(int shot) const;

 private:
  Draws& draws(int shot);

  const Scene& scene_;
  std::uint64_t seed_;
  Lamp lamp_;
  MonoTime last_flash_ = kNoTime;
  std::optional<Draws> draws_;  ///< of the shot below
  int draws_shot_ = 0;
  double sensor_jitter_s_ = 0.0;
};

}  // namespace strobe::sim
