// The sequencer's pins (GPIO numbers of the RP2040), see README.md.
#pragma once

#include "common/flash_sequencer/protocol.hpp"

namespace strobe::sequencer {

inline constexpr unsigned kTxPin = 0, kRxPin = 1;
inline constexpr unsigned kFirstOutputPin = 2;  ///< in the order of OutputLine
inline constexpr unsigned kFirstInputPin = 8;   ///< in the order of InputLine
constexpr unsigned pin_of(flash_sequencer::InputLine line) {
  return kFirstInputPin + static_cast<unsigned>(line);
}
inline constexpr unsigned kKeyPin = pin_of(flash_sequencer::InputLine::key);
inline constexpr unsigned kEstopPin = pin_of(flash_sequencer::InputLine::estop);
inline constexpr unsigned kGatePin = pin_of(flash_sequencer::InputLine::gate);
// Signals between the PIO blocks; not connected.
inline constexpr unsigned kBurstPin = 21, kStartPin = 22;
inline constexpr unsigned kLedPin = 25;

}  // namespace strobe::sequencer
