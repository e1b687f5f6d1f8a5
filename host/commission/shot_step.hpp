// A step that fires shots, the same for all such steps: collects those that are sound, asks again for those
// that were not, waits for their photographs and measures them where that is asked for, then judges.
// Single-threaded; photographs are measured on threads of their own, one at a time, for which the destructor
// waits.
#pragma once

#include <future>
#include <optional>
#include <string>
#include <vector>

#include "host/commission/step.hpp"
#include "host/photographs/measure_photograph.hpp"

namespace strobe::commission {

/// Why nothing can be said of the rig by this shot, of a machine that was too late or that lost edges; empty:
/// it is sound.
std::string why_unsound(const host::Shot& shot);

/// Flashes of these lamps at the rig's own pace; fewer where the rig's limits allow no more. The machine
/// stays still.
ShotPlan dry_train(const host::RigFile& rig, Lamps lamps, int flashes);

/// Of steps whose shot could not be fired; why, for a person.
StepResult no_shot(const std::string& why);

class ShotStep : public Step {
 public:
  static constexpr int kRetries = 8;  ///< unsound shots in all
  struct Photographs {
    int missing = 0;       ///< the step ends once so many of the shots have none; 0: none are wanted
    bool measure = false;  ///< else they are for judge() to read
  };

  ShotStep(std::vector<StepInfo> infos, Needs needs, Photographs photographs)
      : Step(std::move(infos), needs), photographs_(photographs) {}

  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;
  void on_shot(host::Shot shot) override;
  void on_no_shot(const std::string& why) override { problem_ = why; }

 protected:
  /// Sound, in the order in which they were asked for.
  struct SoundShot {
    host::Shot fired;
    std::optional<host::MeasuredPhotograph> measured;  ///< absent: not wanted, or of no use
  };

  /// One for each shot, in their order.
  virtual std::vector<Fire> shots(const host::RigFile& rig) const = 0;
  virtual std::vector<StepResult> judge(const std::vector<SoundShot>& shots, const host::RigFile& rig) = 0;
  /// Of all but the first of infos() where nothing can be judged.
  virtual StepResult left_out(const std::string& why) const { return skipped(why); }
  /// Before a sound shot is collected.
  virtual void on_sound_shot() {}
  /// The first of infos() has this result, the others are left out.
  std::vector<StepResult> nothing_judged(StepResult first, const std::string& why) const;

 private:
  using Measured = std::optional<host::MeasuredPhotograph>;

  Photographs photographs_;
  const host::RigFile* rig_ = nullptr;  ///< as it was when the step began
  std::vector<Fire> wanted_;
  std::vector<SoundShot> shots_;
  std::vector<std::pair<std::size_t, std::shared_future<Measured>>> measuring_;  ///< by their shots
  int repeated_ = 0, missing_ = 0;
  std::string problem_;  ///< why there will be no further shot; empty: there may be
};

}  // namespace strobe::commission
