// What the four machines of a Raspberry Pi 5's PIO block run. Cycles are of 5 ns.
#pragma once

#include "common/flash_sequencer/pio_programs.hpp"

namespace strobe::firmware::rp1_program {

/// What a higher machine writes in a cycle wins: the watchers.
inline constexpr unsigned kMovers = 0, kLamps = 1, kEstopWatch = 2, kKeyWatch = 3;

// A watcher counts X down, in every other cycle, and looks at its pin: high allows. When X has run out, or
// the pin was low in four samples over half a microsecond, it pushes a word and writes zeros in every cycle,
// until it is sent back.
inline constexpr unsigned kWatch = 0, kCut = 6, kHeld = 7;
inline constexpr std::int64_t kCyclesPerCount = 2;
// A player begins with its first delay in X, and the count of its edges less one in Y. Over, it pushes a word
// and counts X down from all ones.
inline constexpr unsigned kNextEdge = 8, kPlay = kNextEdge + 1, kCount = 13;
// The same from the gate's next edge, at which it pushes a word.
inline constexpr unsigned kPlayGated = 15;

constexpr std::array<std::uint16_t, 19> code(unsigned gate, bool gate_active_low) {
  using namespace flash_sequencer::pio;
  constexpr auto kEdges = flash_sequencer::play_edges(kNextEdge);
  constexpr unsigned kSampleApart = 31;
  return {
      jmp(2, If::x_not_zero_then_less),       //  0 watch
      jmp(kCut),                              //  1
      jmp(kWatch, If::pin),                   //  2
      jmp(kWatch, If::pin, kSampleApart),     //  3
      jmp(kWatch, If::pin, kSampleApart),     //  4
      jmp(kWatch, If::pin, kSampleApart),     //  5
      push_noblock(),                         //  6 cut
      mov(To::pins, From::null),              //  7 held; wraps to itself
      kEdges[0],                              //  8 next edge
      kEdges[1],                              //  9 play
      kEdges[2],                              //
      kEdges[3],                              //
      push_noblock(),                         // 12 over
      jmp(kCount, If::x_not_zero_then_less),  // 13 count
      jmp(kCount, If::x_not_zero_then_less),  // 14   the same at zero
      wait_for(gate_active_low, gate),        // 15 play gated
      wait_for(!gate_active_low, gate),       // 16
      push_noblock(),                         // 17
      jmp(kPlay),                             // 18
  };
}
/// From the machine's start to its first edge, beside the delay's count; from the gate's edge, with the two
/// cycles until a machine sees it.
inline constexpr std::int64_t kFirstCycles = 2, kGateCycles = 6;
/// From the last edge to the count's begin.
inline constexpr std::int64_t kOverCycles = 3;

}  // namespace strobe::firmware::rp1_program
