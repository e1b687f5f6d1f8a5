#include "firmware/sequencer/uart.hpp"

#include <bit>

#include "firmware/sequencer/rp2040.hpp"

namespace strobe::sequencer {
namespace {

// One byte, then its time, and so on: each channel starts the other.
constexpr DmaChannel kBytes{2}, kTimes{3};

std::uint32_t address_of(const void* pointer) { return reinterpret_cast<std::uint32_t>(pointer); }

}  // namespace

void Uart::start() {
  kTimes.READ_ADDR.write(TIMERAWL.address());
  kTimes.WRITE_ADDR.write(address_of(times_us_.data()));
  kTimes.TRANS_COUNT.write(1);
  kTimes.AL1_CTRL.write(kDmaEnable | kDmaHighPriority | kDmaWords | kDmaIncrWrite | kDmaRingWrite |
                        dma_ring_bits(std::countr_zero(4 * kReceived)) | dma_chain_to(kBytes.number) |
                        dma_paced_by(kDreqNone));
  kBytes.READ_ADDR.write(UARTDR.address());
  kBytes.WRITE_ADDR.write(address_of(bytes_.data()));
  kBytes.TRANS_COUNT.write(1);
  kBytes.CTRL_TRIG.write(kDmaEnable | kDmaHighPriority | kDmaIncrWrite | kDmaRingWrite |
                         dma_ring_bits(std::countr_zero(kReceived)) | dma_chain_to(kTimes.number) |
                         dma_paced_by(kDreqUart0Rx));
}

bool Uart::take(Received& received) {
  const std::size_t end = (kTimes.WRITE_ADDR.read() - address_of(times_us_.data())) / 4;
  if (taken_ == end % kReceived) return false;
  // The DMA writes them behind the compiler's back.
  received.byte = *const_cast<volatile std::uint8_t*>(&bytes_[taken_]);
  received.timer_us = *const_cast<volatile std::uint32_t*>(&times_us_[taken_]);
  taken_ = (taken_ + 1) % kReceived;
  return true;
}

void Uart::send(std::span<const std::uint8_t> bytes) {
  if (!has_room_for(bytes.size())) return;
  for (const std::uint8_t byte : bytes) to_send_[put_++ % kToSend] = byte;
}

void Uart::pump() {
  while (sent_ != put_ && (UARTFR.read() & kUartTxFull) == 0) UARTDR.write(to_send_[sent_++ % kToSend]);
}

}  // namespace strobe::sequencer
