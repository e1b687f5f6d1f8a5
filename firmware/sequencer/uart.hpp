// UART0. Whatever is received is put into a ring by DMA, each byte with the time at which it was complete: no
// byte is lost or late while the program does something else for less than 20 ms.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace strobe::sequencer {

class Uart {
 public:
  void start();
  struct Received {
    std::uint8_t byte;
    std::uint32_t timer_us;  ///< the timer's low word
  };
  /// The next byte. False: none.
  bool take(Received& received);
  bool has_room_for(std::size_t bytes) const { return kToSend - (put_ - sent_) >= bytes; }
  /// What has no room is dropped.
  void send(std::span<const std::uint8_t> bytes);
  /// To be called often: fills the UART's FIFO.
  void pump();

 private:
  static constexpr std::size_t kReceived = 2048, kToSend = 1024;
  alignas(kReceived) std::array<std::uint8_t, kReceived> bytes_;
  alignas(4 * kReceived) std::array<std::uint32_t, kReceived> times_us_;
  std::size_t taken_ = 0;
  std::array<std::uint8_t, kToSend> to_send_;
  std::size_t put_ = 0, sent_ = 0;
};

}  // namespace strobe::sequencer
