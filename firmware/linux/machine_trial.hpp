// Ten seconds of trains without any output, played as the loop plays them: whether this machine can.
//
// A thread with the loop's rights, CPU and way of waiting (Sequencer::wait) plays trains as long as the rig's
// shot at the lamps' shortest period, with rests in which it sleeps, so that CpuBudget lasts as in a shot. A
// train ends at its first flash that would abort a shot. Set-up only: allocates, starts a thread.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "firmware/core/rig.hpp"
#include "firmware/linux/core_watch.hpp"
#include "firmware/ports/clock.hpp"

namespace strobe::firmware {

/// A flash that would have been issued.
struct TrialFlash {
  MonoTime due;
  MonoTime issued;
  Duration lateness() const { return issued - due; }
};

/// What the playing thread leaves for the one that watches. All memory is there before it starts.
struct TrialTrace {
  explicit TrialTrace(std::size_t room) : flashes(room) {}
  std::vector<TrialFlash> flashes;
  std::atomic<std::size_t> count = 0;    ///< of flashes that are written
  std::atomic<std::int64_t> due_ns = 0;  ///< of the flash that is waited for
  std::atomic<bool> stop = false;
  Duration played{};  ///< in trains, up to the end or the abort of each; read after the thread's end
};

/// Length of the shot that the rig file plans, first flash to last.
Duration length_of_shot(const Rig& rig);

/// Plays until `end`, until the trace is full or told to stop. sleep: as ppoll(2), returns at once for an
/// instant that is past. Real-time safe.
void play_trains(const Rig& rig, Clock& clock, const std::function<void(MonoTime)>& sleep, MonoTime end,
                 TrialTrace& trace);

struct LateFlash {
  TrialFlash flash;
  Culprit culprit;
};

struct MachineTrial {
  std::vector<TrialFlash> flashes;
  std::vector<LateFlash> late;  ///< later than tolerance.late, at most kMaxNamed
  Duration played{};            ///< see TrialTrace
  bool starved = false;         ///< ended since the thread had no CPU for kStarved
  std::string not_named;        ///< why culprits have no names; empty: they have
  std::string not_granted;      ///< what the thread lacked of the loop's rights; empty: nothing

  static constexpr std::size_t kMaxNamed = 500;
  static constexpr Duration kStarved = milliseconds(1000);
};

using CulpritOf = std::function<Culprit(MonoTime from, MonoTime to)>;
/// As CoreWatch::open().
using OpenWatch = std::function<Result<CulpritOf>(const std::set<int>& cpus, pid_t tid)>;

/// Locks the process's memory meanwhile. progress: called some times a second with what has passed.
MachineTrial try_machine(const Rig& rig, const std::set<int>& cpus, Duration length, const OpenWatch& open,
                         const std::function<void(Duration)>& progress);

}  // namespace strobe::firmware
