// A flash sequencer within strobed: its logic in a real-time thread of its own on a Raspberry Pi 5's PIO
// block, and a line to it that is memory of the process.
#pragma once

#include <array>
#include <atomic>
#include <thread>

#include "common/flash_sequencer/controller.hpp"
#include "firmware/flash_sequencer/serial_line.hpp"
#include "firmware/linux/event_fd.hpp"
#include "firmware/ports/clock.hpp"
#include "firmware/rp1_pio/rp1_hardware.hpp"

namespace strobe::firmware {

/// Of several writers and one reader, without locks: a bounded queue after D. Vyukov, each place with the
/// number of its next turn.
class MessageQueue {
 public:
  static constexpr std::size_t kMaxBytes = flash_sequencer::kMaxFrame + 1;
  struct Message {
    std::array<std::uint8_t, kMaxBytes> bytes{};
    std::size_t size = 0;
    MonoTime written;
  };

  MessageQueue();
  /// False: there is no room. Real-time safe, from any thread and signal handler.
  bool push(std::span<const std::uint8_t> bytes, MonoTime written) noexcept;
  /// The reader's: the oldest message until pop(); null: none.
  const Message* front() const noexcept;
  void pop() noexcept;

 private:
  static constexpr std::size_t kPlaces = 64;
  struct Place {
    std::atomic<std::size_t> turn{0};
    Message message;
  };
  std::array<Place, kPlaces> places_;
  std::atomic<std::size_t> end_{0};
  std::size_t first_ = 0;
};

/// The loop's end is the SerialLine, but writes from another process reach nobody.
class LocalLine final : public SerialLine {
 public:
  /// Must outlive this.
  explicit LocalLine(Clock& clock) : clock_(clock) {}

  /// An eventfd that ends wait(), emptied there.
  void set_wake(int wake_fd) { wake_fd_ = wake_fd; }
  bool write(std::span<const std::uint8_t> bytes) noexcept override;
  std::optional<Departure> departure(std::int64_t bytes, MonoTime before, MonoTime after) noexcept override;
  Pace pace() const noexcept override { return {.byte = {}, .reply = {}}; }
  std::optional<std::size_t> read(std::span<std::uint8_t> bytes) noexcept override;
  bool wait(MonoTime until) noexcept override;
  bool poll(MonoTime until) noexcept override;

  // The sequencer's end, one thread's.
  int request_fd() const noexcept { return requests_wait_.fd(); }  ///< an eventfd: something was written
  MessageQueue& requests() noexcept { return requests_; }
  void reply(const flash_sequencer::Frame& frame) noexcept;

 private:
  static constexpr std::size_t kStamps = 16;

  Clock& clock_;
  MessageQueue requests_, replies_;
  EventFd requests_wait_, replies_wait_;
  std::size_t taken_ = 0;  ///< bytes of the oldest reply
  int wake_fd_ = -1;
  std::array<std::atomic<std::int64_t>, kStamps> written_ns_{};  ///< of the newest requests
  std::atomic<std::size_t> next_stamp_{0};
};

/// Cuts the outputs in its constructor: a reset comes first. Should its thread end or hang, the block's
/// watchers cut them.
class LocalSequencer {
 public:
  /// All must outlive this. hardware: taken already; its edge source wakes by the line's request_fd().
  /// boot: drawn for this start.
  LocalSequencer(Rp1Hardware& hardware, LocalLine& line, Clock& clock, std::uint64_t boot);
  LocalSequencer(const LocalSequencer&) = delete;
  LocalSequencer& operator=(const LocalSequencer&) = delete;
  ~LocalSequencer() { stop(); }

  /// Sleeps until something is to be done, and does it. Real-time safe but for that sleep.
  void turn() noexcept;
  /// A thread that turns, until stop(), which cuts the outputs.
  void start(int priority);
  void stop() noexcept;

 private:
  void answer_requests() noexcept;

  Rp1Hardware& hardware_;
  LocalLine& line_;
  Clock& clock_;
  flash_sequencer::Controller controller_;
  flash_sequencer::Decoder decoder_;
  MonoTime newest_request_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace strobe::firmware
