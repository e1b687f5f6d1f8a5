// The rig's side of the simulated GPIO chip: create it, watch its lines, drive its inputs.
//
// The chip lives in one folder: a shared-memory state file, a lock file (ownership by OFD locks), FIFOs for
// events and for what changes on watched lines. A program sees it as /dev/<name> through the preloaded
// library (preload_path()), with STROBE_GPIOCHIP_DIR naming the folder, and speaks the kernel's GPIO uAPI v1
// or v2 with it. Levels here are physical (0 or 1), never inverted by active-low. One Chip object per thread;
// any number of processes may attach. Times are CLOCK_MONOTONIC. A folder in memory (/dev/shm) spares
// programs the page faults of write-back. The chip ends with its creator.
//
// A line's wire can be opened: its level is then that of the chip's own resistor as it was last asked for (a
// bias outlives its request, as in hardware), and without one the level that it had. What holds a line from
// outside is stronger than that resistor.
//
// Not simulated: write() to the chip itself (its descriptors are read-only), hardware time stamps
// (EOPNOTSUPP, as on kernels without them), watches by more than 32 opens of the chip at once (ENOMEM). A
// process that is killed inside a set of several lines may have set only the first of them.
#pragma once

#include <poll.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "sim/gpiochip/state.hpp"
#include "sim/gpiochip/time_keeper.hpp"

namespace strobe::sim {

enum class OnRelease {
  keep,   ///< a released output keeps driving its last level (Raspberry Pi)
  input,  ///< a released output returns to input, read as the line's idle level
};

using gpio::Bias;
using gpio::Cause;

struct LineSpec {
  std::string name;     ///< at most 31 characters; may be empty
  int idle_level = 0;   ///< level while undriven: the board's pull resistor, at the other end of the wire
  int reset_pull = -1;  ///< what the chip's resistor pulls to before a bias was asked for; -1: there is none
  bool kernel_used = false;  ///< used by the kernel: every request gets EBUSY
};

struct ChipSpec {
  std::string name = "gpiochip0";        ///< device node under /dev
  std::string label = "strobe-sim-rig";  ///< at most 31 characters
  std::vector<LineSpec> lines;           ///< 1 to 64
  OnRelease on_release = OnRelease::keep;
  Bias bias = Bias::set;
};

struct Change {
  MonoTime time;  ///< of the change itself, stamped by the process that made it
  std::uint32_t line = 0;
  std::uint8_t level = 0;
  Cause cause = Cause::set;
};

struct LineState {
  int level = 0;
  bool is_output = false;
  bool requested = false;
  std::string consumer;
};

/// A reader's position in the ring of changes.
struct ChangeCursor {
  std::uint64_t next = 0;
};

/// A clock for the threads of the rig's own program: rig time (rig_time.hpp) while the chip keeps one, else
/// the machine's. Thread-safe; of a chip that must outlive it.
class RigClock {
 public:
  RigClock() = default;  ///< the machine's
  explicit RigClock(gpio::State& state) : state_(&state) {}

  MonoTime now() const;
  Duration since_boot() const;  ///< CLOCK_BOOTTIME
  WallTime wall() const;        ///< CLOCK_REALTIME
  void sleep_for(Duration duration) const;
  /// As poll(2).
  int poll(struct pollfd* polled, nfds_t count, Duration timeout) const;
  /// Of what programs draw in a run that is to repeat; 0: they draw as they like.
  std::uint64_t seed() const;

 private:
  gpio::State* state_ = nullptr;
};

class Chip {
 public:
  /// Makes `dir`. Fails if a live chip is in it; one whose creator was killed is replaced.
  static Result<Chip> create(const std::filesystem::path& dir, const ChipSpec& spec);
  static Result<Chip> attach(const std::filesystem::path& dir);
  Chip(Chip&&) noexcept;
  Chip& operator=(Chip&&) noexcept;
  ~Chip();  ///< the creator removes what it made

  std::size_t line_count() const;
  Result<std::uint32_t> line_named(const std::string& name) const;
  std::string line_name(std::uint32_t line) const;  ///< empty if it has none
  LineState state(std::uint32_t line) const;

  /// Drives an input from outside at the instant `stamp` (now or just past): level, ring entry, and, if the
  /// line is requested for that edge, an event with this very stamp. No effect but the latched outside level
  /// on an output.
  /// Cause::set: by a program of the rig's that is wired to it in place of the chip.
  void drive(std::uint32_t line, int level, MonoTime stamp, Cause cause = Cause::drive);
  /// The same for a wire that breaks or is pulled off; the next drive() mends it.
  void open_wire(std::uint32_t line, MonoTime stamp);

  /// Appends to `changes` what happened since the cursor; waits until there is something or the deadline
  /// passes. Returns false if the ring lapped this reader (some changes were lost; the cursor then stands at
  /// the oldest kept). A change wakes the waiter at once. A release by close() or death is looked for once a
  /// millisecond while lines are requested, and is stamped when found, for programs that watch the line too;
  /// so is a change whose process was killed before it could record it (stamped when it happened), and a
  /// debounced line that has settled (its event is stamped when it did).
  bool wait_changes(ChangeCursor& cursor, MonoTime deadline, std::vector<Change>& changes);
  ChangeCursor cursor_now() const;  ///< only changes from now on

  /// The time that stamps are of: the machine's CLOCK_MONOTONIC, or rig time while it is kept (rig_time.hpp).
  MonoTime now() const { return clock().now(); }
  RigClock clock() const;
  /// Keeps rig time from now on until this object ends (time_keeper.hpp). Who waits for changes here is the
  /// rig: its wait_changes() ends at the deadline to the nanosecond, and time waits for what it does then.
  /// Before any thread that is to take part.
  void keep_time(gpio::Pace pace,
                 const std::optional<gpio::TimeKeeper::Repeatable>& repeatable = std::nullopt);
  /// Of rig time: the machine was suspended for so long, and its wall clock is set by as much. False: none
  /// is kept.
  bool set_clocks(Duration suspended, Duration wall_step) const;
  /// Rig time goes on, though no other program has joined yet.
  void begin_time() const;
  /// It stands still until begin_time(), or until another program joins.
  void hold_time() const;
  /// The calling process takes part in rig time, whatever program it becomes.
  void join_time() const;

  /// Rig time waits for what programs write to that terminal, whose other end is the rig's, until it was
  /// taken.
  void await_writes_to(int terminal) const;
  void took_written(std::size_t bytes) const;
  bool keeps_time() const;  ///< rig time

  /// As if the device were unplugged: every further ioctl answers ENODEV, the node is gone, event descriptors
  /// end (poll: hang-up, read: ENODEV) as soon as every rig that is attached made its next call. A chip that
  /// keeps released outputs goes on driving them, as one whose driver was taken away does; one that does not
  /// lets go of every line at once, as an adapter does that lost its power.
  void unplug();
  bool unplugged() const;  ///< also once its creator is gone

  const std::filesystem::path& dir() const;

 private:
  struct Impl;
  explicit Chip(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// The preloaded library beside the running program (…/lib/libstrobe-gpiochip.so, in the build and the
/// install tree).
Result<std::filesystem::path> preload_path();

inline constexpr const char* kChipDirVariable = "STROBE_GPIOCHIP_DIR";

}  // namespace strobe::sim
