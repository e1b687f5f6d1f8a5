// The shared memory of one simulated GPIO chip, and how its words are packed.
//
// Every process that has the chip open maps this one structure. A process may be killed at any instruction:
// there is no lock in it, every change is one compare-and-swap, and what a dead process left half done (a
// level changed but not yet in the ring) is completed by the next process that looks. See levels.hpp.
//
// Times inside are nanoseconds since State::epoch_ns, 52 bits: a simulated chip may live for 52 days.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace strobe::sim::gpio {

inline constexpr std::uint64_t kMagic = 0x53545242'4750494fULL;  // "STRBGPIO"
inline constexpr std::uint32_t kVersion = 8;
inline constexpr std::uint32_t kMaxLines = 64;
inline constexpr std::uint32_t kMaxWatchers = 32;  ///< opens of the chip that can watch lines
inline constexpr std::uint32_t kRingBits = 16;
inline constexpr std::uint64_t kRingSize = std::uint64_t{1} << kRingBits;
inline constexpr std::size_t kNameSize = 32;

/// Files in the chip's folder.
inline constexpr const char* kStateFile = "state";
inline constexpr const char* kLockFile = "locks";
inline constexpr const char* kDeviceFile = "device";       ///< FIFO that an open of /dev/<name> really opens
inline constexpr const char* kSysfsFile = "dev";           ///< what /sys/bus/gpio/devices/<name>/dev reads as
inline constexpr const char* kEventPrefix = "event-";      ///< FIFO of a line's uAPI v1 events
inline constexpr const char* kRequestPrefix = "request-";  ///< FIFO of a v2 request's events
inline constexpr const char* kTerminalFile = "terminal";   ///< FIFO of what programs write to the rig's
inline constexpr const char* kWatchPrefix = "watch-";      ///< FIFO of what changed on watched lines

/// Bytes of the lock file: one per line (its owner), and a few of the chip's own.
inline constexpr std::int64_t kChipLockByte = 1000;
inline constexpr std::int64_t kCreatorByte = 1001;
inline constexpr std::int64_t kDriveByte = 2000;
inline constexpr std::int64_t kEmitByte =
    3000;  ///< of a v2 request: its events are numbered and queued in turn

inline constexpr unsigned kDeviceMajor = 254;

/// Why a line changed.
enum class Cause : std::uint8_t { set = 0, request = 1, release = 2, drive = 3 };

/// What becomes of a request that asks for a bias.
enum class Bias : std::uint32_t {
  set = 0,      ///< the chip has pull-up and pull-down resistors
  ignored = 1,  ///< it has none: Linux grants the request and shows the bias all the same
  refused = 2,  ///< EINVAL, as of a kernel before 5.5 or a driver that says no
};

/// A line's electrical state in one word: how the chip drives it, its level from outside, what the chip's own
/// resistor pulls it to where its wire is open, and the last change. While `pending` is set, that change has
/// not been seen in the ring yet.
struct LevelWord {
  static constexpr std::uint64_t kValue = 1;    ///< level that the chip drives
  static constexpr std::uint64_t kDriven = 2;   ///< the chip drives it
  static constexpr std::uint64_t kOutside = 4;  ///< level where the chip does not drive it
  static constexpr std::uint64_t kPending = 8;
  static constexpr unsigned kCauseShift = 4;
  static constexpr std::uint64_t kOpen = 64;       ///< the wire is open: nothing outside holds the line
  static constexpr std::uint64_t kPulled = 128;    ///< a resistor of the chip pulls
  static constexpr std::uint64_t kPulledUp = 256;  ///< up, else down
  static constexpr unsigned kTimeShift = 12;
  static constexpr std::uint64_t kPins = kValue | kDriven | kOutside | kOpen | kPulled | kPulledUp;

  /// An open line that nothing pulls keeps the level that it had: its charge has nowhere to go.
  static constexpr unsigned level(std::uint64_t word) {
    if ((word & kDriven) != 0) return (word & kValue) != 0 ? 1 : 0;
    const bool pulled = (word & kOpen) != 0 && (word & kPulled) != 0;
    return (word & (pulled ? kPulledUp : kOutside)) != 0 ? 1 : 0;
  }
};

/// One change in the ring, in one word, so that no entry can be half written. The tag is the lap number
/// modulo 8 of the entry's position: it distinguishes an entry of this lap from that of the one before.
struct RingWord {
  static constexpr std::uint64_t kLevel = 1;
  static constexpr unsigned kCauseShift = 1;
  static constexpr unsigned kLineShift = 3;
  static constexpr unsigned kTagShift = 9;
  static constexpr unsigned kTimeShift = 12;
  static constexpr std::uint64_t kTagMask = std::uint64_t{7} << kTagShift;

  static constexpr std::uint64_t tag(std::uint64_t position) {
    return ((position >> kRingBits) & 7) << kTagShift;
  }
  static constexpr std::uint64_t of(std::uint64_t level_word, std::uint32_t line) {
    const std::uint64_t time = level_word >> LevelWord::kTimeShift;
    const std::uint64_t cause = (level_word >> LevelWord::kCauseShift) & 3;
    return (time << kTimeShift) | (std::uint64_t{line} << kLineShift) | (cause << kCauseShift) |
           LevelWord::level(level_word);
  }
};
static_assert(LevelWord::kTimeShift == RingWord::kTimeShift);

/// A line's configuration: changed only under the chip's lock (ownership.hpp).
struct ConfigWord {
  static constexpr std::uint32_t kRequested = 1U << 0;
  static constexpr std::uint32_t kEvents = 1U << 1;  ///< requested for edge events, else as part of a handle
  static constexpr std::uint32_t kIsOut = 1U << 2;   ///< as the kernel's FLAG_IS_OUT; survives a release
  static constexpr std::uint32_t kActiveLow = 1U << 3;
  static constexpr std::uint32_t kOpenDrain = 1U << 4;
  static constexpr std::uint32_t kOpenSource = 1U << 5;
  static constexpr std::uint32_t kPullUp = 1U << 6;
  static constexpr std::uint32_t kPullDown = 1U << 7;
  static constexpr std::uint32_t kBiasDisable = 1U << 8;
  static constexpr std::uint32_t kRising = 1U << 9;    ///< event wanted when the line becomes active
  static constexpr std::uint32_t kFalling = 1U << 10;  ///< event wanted when it becomes inactive
  static constexpr std::uint32_t kKernelUsed = 1U << 11;
  static constexpr std::uint32_t kVersion2 = 1U << 12;  ///< requested by uAPI v2
  static constexpr std::uint32_t kRealtime = 1U << 13;  ///< its events are stamped by CLOCK_REALTIME
  static constexpr unsigned kSlotShift = 16;            ///< index of the handle or v2 request
  static constexpr std::uint32_t kSlotMask = 0x3fU << kSlotShift;
  /// The kernel, too, forgets the clock only at the next v2 request.
  static constexpr std::uint32_t kKeptByRelease = kIsOut | kKernelUsed | kRealtime;

  static constexpr std::uint32_t slot(std::uint32_t config) { return (config & kSlotMask) >> kSlotShift; }
};

/// A debounced line: the level that counts, and the time of an edge whose period is not over yet.
struct DebounceWord {
  static constexpr std::uint64_t kLevel = 1;
  static constexpr std::uint64_t kBouncing = 2;
  static constexpr unsigned kTimeShift = 12;
};

struct alignas(64) Line {
  std::atomic<std::uint64_t> level;
  std::atomic<std::uint32_t> config;
  std::uint32_t idle_level;
  std::atomic<std::uint64_t> consumer[kNameSize / 8];
  char name[kNameSize];
  std::uint64_t fifo_inode;
  std::atomic<std::uint64_t> debounce;
  std::atomic<std::uint32_t> debounce_us;  ///< 0: not debounced
  std::atomic<std::uint32_t> seqno;        ///< of its newest event in this v2 request
};

/// Lines of one line handle or v2 request. A handle's descriptor names its slot and serial by its file offset
/// (ownership.hpp), a v2 request's is the FIFO of its slot.
struct alignas(64) Handle {
  std::atomic<std::uint32_t> serial;
  std::atomic<std::uint32_t> count;
  std::atomic<std::uint32_t> seqno;        ///< of the newest event
  std::atomic<std::uint32_t> event_depth;  ///< events that wait at most, before the oldest is dropped
  std::atomic<std::uint8_t> lines[kMaxLines];
};

/// One open of the chip, as far as it watches lines.
struct Watcher {
  std::atomic<std::uint64_t> lines;    ///< watched, by bit; also of one that died, until that is found
  std::atomic<std::uint32_t> version;  ///< of the uAPI: 0 before its first watch
};

/// Sizes of records that were ever read from this chip beside v1's events, by bit: what need not be looked
/// for costs nothing.
struct RecordSizes {
  static constexpr std::uint32_t kEvent = 1U << 0;          ///< v2's events
  static constexpr std::uint32_t kInfoChanged = 1U << 1;    ///< v2's watches
  static constexpr std::uint32_t kInfoChangedV1 = 1U << 2;  ///< v1's watches
};

inline constexpr std::uint32_t kMaxPrograms = 64;
inline constexpr std::uint32_t kMaxWaits = 192;  ///< threads that ever waited for an instant

enum class Pace : std::uint32_t { machine = 0, wall = 1, fast = 2 };  ///< see rig_time.hpp

/// What ends a thread's wait at its instant.
enum class WakeBy : std::uint32_t {
  signal,  ///< in ppoll()
  word,    ///< a futex on TimedWait::woken
  ring,    ///< a futex on State::wake: the rig's thread
  itself   ///< it looks each millisecond of the machine's
};

/// One thread's wait for an instant.
struct alignas(64) TimedWait {
  std::atomic<std::int64_t> until_ns;  ///< INT64_MAX: it does not wait for any
  std::atomic<std::int32_t> tid;       ///< 0: free
  std::atomic<std::int32_t> pid;
  std::atomic<WakeBy> wake_by;
  std::atomic<std::uint32_t> woken;  ///< futex: grows when the instant has come
};

/// The time that the programs of a rig share (rig_time.hpp). [ns of CLOCK_MONOTONIC]
struct alignas(64) RigTime {
  std::atomic<Pace> pace;
  std::atomic<std::uint32_t> beats;            ///< of the keeper: grows as long as there is one
  std::uint64_t seed;                          ///< of what programs draw; 0: nothing is fixed
  std::atomic<std::uint32_t> begun;            ///< time stands still before
  std::atomic<std::uint64_t> streams;          ///< programs that have drawn
  std::atomic<std::int64_t> now_ns;            ///< once kept
  std::atomic<std::int64_t> ahead_ns;          ///< of the machine's, of clocks that are kept no longer
  std::atomic<std::int64_t> realtime_less_ns;  ///< CLOCK_REALTIME minus CLOCK_MONOTONIC
  std::atomic<std::int64_t> boottime_less_ns;  ///< CLOCK_BOOTTIME minus CLOCK_MONOTONIC
  std::atomic<std::int64_t> next_ns;   ///< earliest instant that others than loop and rig wait for, or before
  std::atomic<std::uint32_t> asleep;   ///< futex: grows when the loop lies down
  std::atomic<std::int32_t> loop_tid;  ///< 0: no loop yet
  std::atomic<std::int32_t> loop_pid;
  std::atomic<std::uint64_t> loop_looks;  ///< at the clock
  // The rig's thread: while it sleeps.
  std::atomic<std::uint32_t> turns;  ///< futex: grows when it has done what was due and lies down
  std::atomic<std::int64_t> rig_ns;  ///< what it waits for
  std::atomic<std::uint64_t> seen;   ///< position in the ring up to which it has seen the changes
  // Of the terminal whose other end is the rig's: what was written to it has not been taken yet.
  std::atomic<std::uint64_t> terminal_device, terminal_inode;  ///< 0: there is none
  std::atomic<std::uint64_t> terminal_written, terminal_taken;
  std::atomic<std::int32_t> programs[kMaxPrograms];  ///< process ids; 0: free
  TimedWait waits[kMaxWaits];
};

/// Before the bytes of each write in kTerminalFile.
struct TerminalWrite {
  static constexpr std::size_t kMaxSize = 1024;  ///< of more, so many are written
  std::int64_t at_ns;
  std::uint64_t size;
};

struct State {
  std::atomic<std::uint64_t> magic;  ///< written last by the creator
  std::uint32_t version;
  std::uint32_t line_count;
  std::uint32_t input_on_release;
  Bias bias;
  std::atomic<std::uint32_t> record_sizes;
  char name[kNameSize];
  char label[kNameSize];
  std::int64_t epoch_ns;
  std::uint64_t device_inode;
  std::uint64_t lock_inode;
  std::uint64_t folder_device;
  std::atomic<std::uint32_t> unplugged;
  std::atomic<std::uint32_t> last_serial;
  std::uint64_t request_inodes[kMaxLines];
  std::uint64_t watch_inodes[kMaxWatchers];
  Watcher watchers[kMaxWatchers];

  alignas(64) std::atomic<std::uint64_t> head;  ///< position of the next ring entry
  alignas(64) std::atomic<std::uint32_t> wake;  ///< futex: grows with every change
  std::atomic<std::uint32_t> waiting;           ///< a process may be sleeping on `wake`

  RigTime time;

  Line lines[kMaxLines];
  Handle handles[kMaxLines];
  alignas(64) std::atomic<std::uint64_t> ring[kRingSize];
};

static_assert(std::atomic<std::uint64_t>::is_always_lock_free &&
              std::atomic<std::uint32_t>::is_always_lock_free);

}  // namespace strobe::sim::gpio
