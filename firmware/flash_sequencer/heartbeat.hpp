// The beats that keep a flash sequencer playing. They come from a thread of their own, for as long as the
// loop is known to turn, so that neither a loop that hangs nor a machine that stands still plays on.
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
  /// A loop whose last turn is older than this hangs. It turns every 50 ms.
  static constexpr Duration kLoopHangs = milliseconds(150);
  /// Beats have the numbers from here to 255, other requests those below.
  static constexpr std::uint8_t kFirstNumber = 128;

  /// line and clock must outlive this.
  Heartbeat(SerialLine& line, Clock& clock) : line_(line), clock_(clock) {}
  ~Heartbeat() { stop(); }

  /// One beat now. By one thread at a time. Real-time safe.
  void beat() noexcept;
  /// Between which instants the newest beat of that number has left. Returns nullopt if there was none.
  /// Thread-safe.
  std::optional<SerialLine::Departure> departure(std::uint8_t number) const noexcept;

  /// Starts the thread. loop_turned_ns: when the loop last turned, 0 before it first did; must outlive this.
  void start(const std::atomic<std::int64_t>& loop_turned_ns, int priority);
  void stop() noexcept;

 private:
  void run(const std::atomic<std::int64_t>& loop_turned_ns, int priority) noexcept;

  SerialLine& line_;
  Clock& clock_;
  std::uint8_t next_ = kFirstNumber;
  struct Sent {
    std::atomic<std::int64_t> not_before_ns{0}, not_after_ns{0};  ///< 0: not known
  };
  std::array<Sent, 256 - kFirstNumber> sent_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace strobe::firmware
