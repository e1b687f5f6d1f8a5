// Brings the chip up: clocks, pins, UART. The state after a reset is the safe one: all pins are inputs,
// pulled down.
#pragma once

#include <cstdint>

namespace strobe::sequencer {

/// Crystal 12 MHz -> 125 MHz for processor, PIO and UART; 1 us for timer and watchdog; UART0 1,000,000 baud
/// 8N1.
void set_up_chip();
/// Whether this start is the watchdog's.
bool started_by_watchdog();
/// From now on the chip is reset when it is not fed for kWatchdog_us; that makes inputs of all pins.
void start_watchdog();
void feed_watchdog();
inline constexpr std::uint32_t kWatchdog_us = 18'000;
/// From the phase noise of the ring oscillator.
std::uint32_t random_bits();

}  // namespace strobe::sequencer
