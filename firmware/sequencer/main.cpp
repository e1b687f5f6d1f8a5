// The flash sequencer: one loop, no interrupts. Only a loop that comes round feeds the watchdog.
#include <array>
#include <cstddef>
#include <new>
#include <utility>

#include "common/flash_sequencer/controller.hpp"
#include "firmware/sequencer/chip.hpp"
#include "firmware/sequencer/rp2040.hpp"
#include "firmware/sequencer/rp2040_hardware.hpp"
#include "firmware/sequencer/uart.hpp"
#include "firmware/sequencer/wiring.hpp"

namespace strobe::sequencer {
namespace {

using namespace flash_sequencer;

void send(Uart& uart, const Frame& frame) {
  std::array<std::uint8_t, kMaxFrame> wire;
  uart.send(std::span(wire).first(encode(frame, wire)));
}

/// One request at most, so that what guards the outputs is never far. Its reply leaves at `send_from`.
void receive(Uart& uart, Decoder& decoder, Rp2040Hardware& hardware, Controller& controller,
             Ticks& send_from) {
  Uart::Received received;
  while (uart.take(received)) {
    const Frame* const request = decoder.take(received.byte);
    if (request == nullptr) continue;
    const Ticks at = hardware.ticks_of(received.timer_us);
    Frame reply;
    if (!controller.answer(*request, at, reply)) return;
    send(uart, reply);
    send_from = at + kReplyAfter;
    return;
  }
}

/// An object that is never destroyed.
template <typename Object, typename... Arguments>
Object& make_forever(Arguments&&... arguments) {
  alignas(Object) static std::array<std::byte, sizeof(Object)> room;
  return *new (room.data()) Object(std::forward<Arguments>(arguments)...);
}

[[noreturn]] void hang() {
  for (;;) {
  }
}

[[noreturn]] void run() {
  const bool by_watchdog = started_by_watchdog();
  set_up_chip();
  start_watchdog();
  auto& uart = make_forever<Uart>();
  auto& decoder = make_forever<Decoder>();
  auto& hardware = make_forever<Rp2040Hardware>();
  uart.start();
  if (!hardware.start()) hang();  // cut, until the watchdog tries again
  const std::uint64_t boot = std::uint64_t{random_bits()} << 32 | random_bits();
  auto& controller = make_forever<Controller>(hardware, boot, by_watchdog);
  for (Ticks send_from = 0;;) {
    hardware.poll();
    controller.turn();
    receive(uart, decoder, hardware, controller, send_from);
    Frame report;
    if (uart.has_room_for(2 * kMaxFrame) && controller.next_input(report)) send(uart, report);
    if (hardware.now() >= send_from) uart.pump();
    const bool ready = controller.phase() == Phase::armed || controller.phase() == Phase::playing;
    (ready ? GPIO_OUT_SET : GPIO_OUT_CLR).write(bit(kLedPin));
    feed_watchdog();
  }
}

}  // namespace
}  // namespace strobe::sequencer

int main() { strobe::sequencer::run(); }

// Destructors that can be overridden ask for these.
void operator delete(void*) noexcept { strobe::sequencer::hang(); }
void operator delete(void*, std::size_t) noexcept { strobe::sequencer::hang(); }
