// Whole simulated shots in one process: an ideal train of flashes instead of the firmware drives the rig; the
// result is a frame for the reduction, with the truth. No clock, no threads, no I/O: the same scene, seed,
// shot, model and settings give the same bytes, whatever shots came before.
//
// The shutter is held open around the train (its line rises the longest lag before the first flash), so that
// it does not matter; the ball is triggered such that one with the mean lag meets the plate in the middle of
// the train's window. An image's time in the frame is, as in a session, the mean of the flash sensors' edges
// of its flash, from the first image's.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/result.hpp"
#include "sim/rig/exposure.hpp"
#include "sim/rig/rig.hpp"
#include "sim/scene/model.hpp"

namespace strobe::sim {

struct ShootSettings {
  Duration period = milliseconds(3);  ///< between flashes; 100 µs…1 s
  /// How long the train lasts, at most 2 s. 0: as long as the scene's balls take to cross the camera's view
  /// (spreads of speed, angle and lag included), but before and after the impact not more than 0.25 s and the
  /// margins for lag and period.
  Duration exposure{};
  /// When the flashes are commanded, from the first, ascending; instead of period and exposure. Empty: an
  /// even train.
  std::vector<Duration> train{};
  bool perfect_digitizer = false;  ///< the frame states the tablet's noise but has none
};

enum class ShotFlag {
  no_ball,          ///< the machine threw none, or one outside the contact mechanics' range
  ball_missed,      ///< it missed the plate
  impact_unseen,    ///< it met the plate when the shutter was closed
  unstamped_image,  ///< an image was left out of the frame: no sensor saw its flash
};
inline constexpr std::array<std::string_view, 4> kShotFlagNames{"no_ball", "ball_missed", "impact_unseen",
                                                                "unstamped_image"};

struct SimulatedShot {
  Exposure exposure;
  reduction::Frame frame;         ///< without images where there is no ball
  std::vector<int> image_pulse;   ///< for each image of the frame its pulse's index in the exposure
  reduction::Quantities truth{};  ///< of the ball that met the plate; all absent without one
  std::bitset<kShotFlagNames.size()> flags;

  bool has(ShotFlag flag) const { return flags[static_cast<std::size_t>(flag)]; }
};

/// Many shots of one scene, prepared once. Not thread-safe; independent objects are.
class Shooter {
 public:
  /// Fails for settings out of range.
  static Result<Shooter> make(const Scene& scene, std::uint64_t seed, const Model& model = Model::full(),
                              const ShootSettings& settings = {});

  /// The `shot`-th shot (1-based); in any order.
  SimulatedShot shoot(int shot);

  /// The scene with the model's effects only.
  const Scene& scene() const { return rig_->scene(); }
  int flashes() const { return flashes_; }

 private:
  Shooter(const Scene& scene, std::uint64_t seed, const Model& model, const ShootSettings& settings);

  void play(int shot);
  void fill_frame(SimulatedShot& shot) const;
  Duration offset(int flash) const;

  ShootSettings settings_;
  std::unique_ptr<Rig> rig_;
  int flashes_ = 0;
  Duration before_{};      ///< first flash to the mean ball's impact
  Duration open_ahead_{};  ///< shutter line to first flash
  std::vector<Drive> drives_;
  std::vector<Exposure> exposures_;
};

/// One shot. For many use Shooter, which prepares the scene once.
Result<SimulatedShot> shoot(const Scene& scene, std::uint64_t seed, int shot,
                            const Model& model = Model::full(), const ShootSettings& settings = {});

}  // namespace strobe::sim
