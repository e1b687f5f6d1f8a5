// What the PIO blocks run. Cycles are of 8 ns.
#pragma once

#include <array>
#include <cstdint>

#include "common/flash_sequencer/pio_programs.hpp"
#include "firmware/sequencer/wiring.hpp"

namespace strobe::sequencer {

namespace pio = flash_sequencer::pio;
using flash_sequencer::kEdgeCycles;

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
inline constexpr auto kEdges = flash_sequencer::play_edges(kNextEdge);
inline constexpr std::array<std::uint16_t, 17> kCode = {
    jmp(0, If::pin),                   //  0 watch
    set(To::x, 31),                    //  1
    jmp(0, If::pin),                   //  2
    jmp(2, If::x_not_zero_then_less),  //  3
    mov(To::pins, From::null),         //  4 cut; wraps to itself
    out_all(To::y),                    //  5 play
    wait_for(true, kStartPin, 2),      //  6   as late as from the gate
    kEdges[0],                         //  7 next edge
    kEdges[1],
    kEdges[2],
    kEdges[3],                  // 10
    jmp(11),                    // 11 over
    out_all(To::y),             // 12 play gated
    wait_for(false, kGatePin),  // 13 listen
    wait_for(true, kGatePin),   // 14
    set(To::pins, 1),           // 15
    jmp(7),                     // 16
};
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
    mov(To::isr, From::x),             //  0 rise
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
