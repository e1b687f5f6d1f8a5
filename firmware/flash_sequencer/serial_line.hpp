// Port: the bytes to and from a flash sequencer.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "common/flash_sequencer/protocol.hpp"
#include "common/units/time.hpp"

namespace strobe::firmware {

/// A start bit, eight bits, a stop bit.
inline constexpr Duration kByteTime = microseconds(10);
inline constexpr Duration kReplyAfter{flash_sequencer::kReplyAfter * flash_sequencer::kTick_ns};

/// Real-time safe but for the sleep that wait() is. write() and departure() from any thread, write() also
/// from another process and a signal handler: no allocation, no lock. The rest is one thread's.
class SerialLine {
 public:
  virtual ~SerialLine() = default;
  /// What a byte takes on its way, and between a request and its reply passes at least.
  struct Pace {
    Duration byte, reply;
  };
  virtual Pace pace() const noexcept { return {kByteTime, kReplyAfter}; }
  /// Hands all bytes over in one call, so that those of two threads do not mix. Returns false if there was no
  /// room for all of them, or the line is gone.
  virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// Between which instants the last of so many bytes has left, that were written between those two to an
  /// idle line; waits for it, a fraction of a millisecond. Returns nullopt if the line cannot tell.
  struct Departure {
    MonoTime not_before, not_after;
  };
  virtual std::optional<Departure> departure(std::int64_t bytes, MonoTime before,
                                             MonoTime after) noexcept = 0;
  /// Takes what has come, without waiting: fills `bytes` from its start and returns their number. Returns
  /// nullopt if the line is gone.
  virtual std::optional<std::size_t> read(std::span<std::uint8_t> bytes) noexcept = 0;
  /// Sleeps until there is something to read, somebody wakes the thread, or the instant has come; not at all
  /// if that has passed. Returns false in the last case.
  virtual bool wait(MonoTime until) noexcept = 0;
  /// The same without sleeping. A virtual clock may skip the time between.
  virtual bool poll(MonoTime until) noexcept = 0;
};

/// A frame, after a zero that ends what was cut off before it. As write().
inline bool send(SerialLine& line, const flash_sequencer::Frame& frame) noexcept {
  std::array<std::uint8_t, flash_sequencer::kMaxFrame + 1> wire{};
  const std::size_t size =
      flash_sequencer::encode(frame, std::span(wire).subspan<1, flash_sequencer::kMaxFrame>());
  return line.write(std::span(wire).first(1 + size));
}

/// Bytes of a frame as send() writes it; without the zero before it, as the sequencer does.
constexpr std::int64_t sent_size(const flash_sequencer::Frame& frame) { return frame.size + 9; }
constexpr std::int64_t heard_size(const flash_sequencer::Frame& frame) { return frame.size + 8; }

}  // namespace strobe::firmware
