// What the PIO blocks run. Cycles are of 8 ns.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/sequencer/wiring.hpp"

namespace strobe::sequencer {

namespace pio {
enum class If : unsigned { always = 0, x_not_zero_then_less = 2, y_not_zero_then_less = 4, pin = 6 };
enum class To : unsigned { pins = 0, x = 1, y = 2, pindirs = 4, isr = 6, osr = 7 };
constexpr std::uint16_t word(unsigned code) { return static_cast<std::uint16_t>(code); }
constexpr std::uint16_t jmp(unsigned address, If condition = If::always) {
  return word(0x0000U | static_cast<unsigned>(condition) << 5 | address);
}
constexpr std::uint16_t wait_for(bool level, unsigned gpio, unsigned delay = 0) {
  return word(0x2000U | delay << 8 | (level ? 0x80U : 0U) | gpio);
}
constexpr std::uint16_t out_all(To to) { return word(0x6000U | static_cast<unsigned>(to) << 5); }
constexpr std::uint16_t push_noblock() { return 0x8000; }
constexpr std::uint16_t mov_null(To to, bool inverted = false) {
  return word(0xa000U | static_cast<unsigned>(to) << 5 | (inverted ? 0x08U : 0U) | 3U);
}
constexpr std::uint16_t mov_x(To to) { return word(0xa000U | static_cast<unsigned>(to) << 5 | 1U); }
constexpr std::uint16_t set(To to, unsigned value) {
  return word(0xe000U | static_cast<unsigned>(to) << 5 | value);
}
}  // namespace pio

/// PIO0: two machines play the tracks, two watch e-stop and key. What a higher machine writes in a cycle
/// wins.
namespace outputs_program {
using namespace pio;
// Watches its pin: high allows. Low for all of 64 cycles and it writes zeros in every cycle, until the
// program sends it back.
inline constexpr unsigned kWatch = 0, kCut = 4;
// Plays a track: the count of its edges less one, then for each its delay less kEdgeCycles, and levels.
inline constexpr unsigned kPlay = 5, kNextEdge = 7, kOver = 11;
// The same from the gate's next rising edge; it raises BURST then.
inline constexpr unsigned kPlayGated = 12, kListen = 13, kHeardGate = 15;
inline constexpr std::array<std::uint16_t, 17> kCode = {
    jmp(0, If::pin),                   //  0 watch
    set(To::x, 31),                    //  1
    jmp(0, If::pin),                   //  2
    jmp(2, If::x_not_zero_then_less),  //  3
    mov_null(To::pins),                //  4 cut; wraps to itself
    out_all(To::y),                    //  5 play
    wait_for(true, kStartPin, 2),      //  6   as late as from the gate
    out_all(To::x),                    //  7 next edge
    jmp(8, If::x_not_zero_then_less),  //  8
    out_all(To::pins),                 //  9
    jmp(7, If::y_not_zero_then_less),  // 10   OUT after OUT would wait for the shift register
    jmp(11),                           // 11 over
    out_all(To::y),                    // 12 play gated
    wait_for(false, kGatePin),         // 13 listen
    wait_for(true, kGatePin),          // 14
    set(To::pins, 1),                  // 15
    jmp(7),                            // 16
};
inline constexpr std::uint32_t kEdgeCycles = 4;   ///< of an edge, beside its delay's count
inline constexpr std::uint32_t kFirstCycles = 7;  ///< from START's or the gate's edge to the first, likewise
inline constexpr std::int64_t kGateToBurst = 3;   ///< cycles from the gate's edge to BURST's
}  // namespace outputs_program

/// PIO1: each machine counts X down in every other cycle, whatever it does, and pushes it when its pin rises.
namespace stamps_program {
using namespace pio;
inline constexpr unsigned kLow = 7, kWrapTop = 8;
inline constexpr std::int64_t kCyclesPerCount = 2;
// A decrement that jumps to the next instruction does the same at zero.
inline constexpr std::array<std::uint16_t, 9> kCode = {
    mov_x(To::isr),                    //  0 rise
    push_noblock(),                    //  1
    jmp(3, If::x_not_zero_then_less),  //  2   three, for six cycles since the pin was seen
    jmp(4, If::x_not_zero_then_less),  //  3
    jmp(5, If::x_not_zero_then_less),  //  4 still
    jmp(4, If::pin),                   //  5 high
    jmp(7, If::x_not_zero_then_less),  //  6
    jmp(0, If::pin),                   //  7 low
    jmp(7, If::x_not_zero_then_less),  //  8   wraps to low
};
}  // namespace stamps_program

}  // namespace strobe::sequencer
