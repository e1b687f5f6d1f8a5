// The rig's flash sequencer: the microcontroller's logic (common/flash_sequencer) on a simulated board whose
// pins are the wires of the rig, behind a pseudo terminal with a serial line's pace. A thread of its own, in
// rig time: what it does takes none. Start and stop from one thread.
//
// Three lines of the chip are no wires of the rig, but what a test does to it.
#pragma once

#include <atomic>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <vector>

#include "common/flash_sequencer/controller.hpp"
#include "common/result.hpp"
#include "sim/flash_sequencer/board.hpp"
#include "sim/flash_sequencer/terminal.hpp"
#include "sim/gpiochip/chip.hpp"

namespace strobe::sim::sequencer {

/// Offset, name and idle level of a line of the chip.
struct ControlLine {
  std::uint32_t line;
  std::string_view name;
  int idle_level;
};
inline constexpr ControlLine kNoise{13, "SEQUENCER_NOISE", 0};  ///< 1: a byte in 2000 is damaged
inline constexpr ControlLine kRun{14, "SEQUENCER_RUN", 1};      ///< 0: held in reset, as by a brown-out
inline constexpr ControlLine kCable{15, "SEQUENCER_CABLE", 1};  ///< 0: its serial line is pulled out
inline constexpr std::array kControlLines{kNoise, kRun, kCable};

class FlashSequencer {
 public:
  /// `port` becomes a link to its terminal. The chip in `chip_folder` and the clock, which is that of the
  /// rig's own program, must outlive it.
  static Result<std::unique_ptr<FlashSequencer>> create(const std::filesystem::path& port,
                                                        const std::filesystem::path& chip_folder,
                                                        std::uint64_t seed, RigClock clock);
  ~FlashSequencer();
  FlashSequencer(const FlashSequencer&) = delete;
  FlashSequencer& operator=(const FlashSequencer&) = delete;

  void start();
  void stop();

  /// By the thread that sees the chip's lines change: key and e-stop act before this returns.
  void lines_changed(const std::vector<Change>& changes);

 private:
  struct Byte {
    MonoTime arrived;
    std::uint8_t value;
  };
  struct Reply {
    MonoTime sent;  ///< its last byte
    std::vector<std::uint8_t> wire;
  };

  FlashSequencer(Chip chip, std::uint64_t seed, RigClock clock);
  void run();
  void turn();
  Duration until_due() const;
  void power_up(MonoTime now);
  void line_changed(const Change& change);
  void take_bytes(MonoTime now);
  void answer_requests(MonoTime now);
  void send(const flash_sequencer::Frame& frame, MonoTime begin);
  void deliver(MonoTime now);
  std::uint8_t on_the_way(std::uint8_t byte);
  void move_pins();

  Chip chip_;
  const RigClock clock_;
  std::optional<Terminal> terminal_;
  const int event_;  ///< something was done to it, or it is to stop
  std::atomic<bool> stopping_{false};
  std::thread thread_;

  std::mutex mutex_;  ///< of all below
  Draws draws_;
  Board board_;
  std::optional<flash_sequencer::Controller> controller_;  ///< none: held in reset
  flash_sequencer::Decoder decoder_;
  bool plugged_in_ = true, noisy_ = false;
  std::deque<Byte> bytes_;
  std::deque<Reply> replies_;
  MonoTime incoming_free_, outgoing_free_;  ///< when the line's direction has carried what was sent
};

}  // namespace strobe::sim::sequencer
