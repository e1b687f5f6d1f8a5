// The simulated rig in virtual time: changes of the chip's output lines go in; the input lines' changes and
// the exposures taken come out. No clock, no threads, no I/O, so that tests run thousands of shots
// in-process; RigRunner couples it to a chip in real time.
//
// The same scene, seed and line changes give the same results. Draws of a shot do not depend on earlier
// shots. Not thread-safe; allocates.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "sim/rig/exposure.hpp"
#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// An input line to be driven to `level` at the instant `at`.
struct Drive {
  MonoTime at;
  RigLine line = RigLine::gate;
  int level = 0;
};

class Rig {
 public:
  /// Lines are at their idle levels at `start`; the operator's actions are timed from it. A model other
  /// than the full one leaves effects out (see model.hpp); scene() is then what is left.
  Rig(const Scene& scene, std::uint64_t seed, MonoTime start, const Model& model = Model::full());
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  /// Resets to `start`, as if newly made; the next exposure has the number `shot` (1-based).
  void restart(int shot, MonoTime start);

  /// Whether the gate's edges are computed (default: yes).
  void watch_gate(bool watched) { gate_watched_ = watched; }

  /// An output line's level at `at`; changes come in order of time. Repeated levels and inputs are ignored.
  void line_changed(RigLine line, int level, MonoTime at);

  /// The next instant at which collect() has something to return; far in the future if there is none.
  MonoTime next_due() const;

  /// Appends what is due up to `now`, drives in order of time. An exposure is returned 20 ms after it closed,
  /// when every edge of it must have been reported.
  void collect(MonoTime now, std::vector<Drive>& drives, std::vector<Exposure>& exposures);

  /// Ends an exposure that is still open, as when the program under test has died.
  void finish(MonoTime now, std::vector<Exposure>& exposures);

  /// The simulation fell behind real time: the current exposure does not test the program fairly.
  void mark_overrun() {
    if (current_) current_->overrun = true;
  }

  /// The shutter line's change that began the current exposure. Returns nullopt between exposures.
  std::optional<MonoTime> exposing_since() const;
  const Scene& scene() const { return scene_; }
  const Model& model() const { return model_; }
  std::uint64_t seed() const { return seed_; }

 private:
  void on_strobe(Lamp lamp, MonoTime at);
  void on_shutter(int level, MonoTime at);
  void on_trigger(MonoTime at);
  FlashPlace begin_or_join_pulse(Lamp lamp, MonoTime at);
  std::optional<int> predict_place(MonoTime edge) const;
  void drop_by_hand();
  void sense_beside(Lamp lamp, MonoTime rise);
  void release_shutter(MonoTime at);
  void drive_gate(const BallPath& path, MonoTime touchdown, MonoTime trigger, int shot);
  MonoTime sense(Lamp lamp, MonoTime flash, const FlashPlace& place, std::vector<FaultKind>& occurred);
  bool drive_sensor(RigLine line, MonoTime rise);
  void bounce_sensor(RigLine line, MonoTime rise, Duration after);
  void schedule(const Drive& drive);
  void note_faults(const std::vector<FaultKind>& kinds);

  /// What the machine has thrown for the exposure that has not begun yet.
  struct Waiting {
    std::optional<ThrownBall> ball;
    std::vector<ThrownBall> more_balls;
    int throws = 0;
    MonoTime triggered = kNoTime;
    std::vector<FaultKind> faults;
  };

  const Model model_;
  const Scene scene_;
  const std::uint64_t seed_;
  std::optional<ReducedContact> reduced_;
  std::array<int, kWiredLines> levels_{};
  std::array<LampModel, 2> lamps_;
  std::array<bool, 2> in_pulse_{};  ///< which lamps the newest pulse has reached
  MonoTime pulse_edge_ = kNoTime;
  MonoTime previous_edge_ = kNoTime;
  int pulses_ = 0;  ///< of the current exposure, or since the last one
  int exposures_ = 0;
  std::optional<Exposure> current_;
  std::size_t most_pulses_ = 0;  ///< of an exposure: room for as many is made at once
  std::vector<Exposure> finished_;
  std::optional<Draws> shutter_draws_;
  Waiting waiting_;
  bool gate_watched_ = true;
  std::vector<Drive> pending_;  ///< latest first
};

}  // namespace strobe::sim
