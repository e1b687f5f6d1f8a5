// The beats that keep a flash sequencer playing. They come from a thread of their own, and from one on the
// loop's CPU once the first is late, so that no CPU that stands still ends a shot by itself; for as long as
// the loop is known to turn, so that neither a loop that hangs nor a machine that stands still plays on.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>

#include "firmware/flash_sequencer/serial_line.hpp"
#include "firmware/ports/clock.hpp"

namespace strobe::firmware {

class Heartbeat {
 public:
  static constexpr Duration kEvery = milliseconds(4);
  static constexpr Duration kLate = milliseconds(5);  ///< after the newest beat: the other thread's turn
  /// A loop whose last turn is older than this hangs. It turns every 50 ms.
  static constexpr Duration kLoopHangs = milliseconds(150);
  /// Beats have the numbers from here to 255, other requests those below.
  static constexpr std::uint8_t kFirstNumber = 128;

  /// line and clock must outlive this.
  Heartbeat(SerialLine& line, Clock& clock) : line_(line), clock_(clock) {}
  ~Heartbeat() { stop(); }

  /// One beat now. Thread-safe and real-time safe.
  void beat() noexcept;
  /// Between which instants the newest beat of that number has left. Returns nullopt if there was none; and
  /// of those that were not watched, once the line has told of one when it left. Thread-safe.
  std::optional<SerialLine::Departure> departure(std::uint8_t number) const noexcept;

  /// Starts the threads. loop_turned_ns: when the loop last turned, 0 before it first did; must outlive this.
  /// loop_cpu: -1: the loop, and one thread of these, may run on any.
  void start(const std::atomic<std::int64_t>& loop_turned_ns, int priority, int loop_cpu);
  void stop() noexcept;

 private:
  void run(const std::atomic<std::int64_t>& loop_turned_ns, Duration after) noexcept;

  SerialLine& line_;
  Clock& clock_;
  std::atomic<std::uint8_t> beats_{0};
  std::atomic<std::int64_t> beaten_ns_{0};  ///< the newest one
  std::atomic<bool> line_tells_{false};
  struct Sent {
    std::atomic<std::int64_t> not_before_ns{0}, not_after_ns{0};  ///< 0: not known
  };
  std::array<Sent, 256 - kFirstNumber> sent_;
  std::atomic<bool> stop_{false};
  std::array<std::thread, 2> threads_;
};

}  // namespace strobe::firmware
