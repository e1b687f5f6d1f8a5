// What the PIO blocks of a flash sequencer run: instructions and registers as the RP2040's datasheet has them
// (3.4 and 3.7; the RP1's are the same), and how a machine plays the edges of a track.
#pragma once

#include <array>
#include <cstdint>

namespace strobe::flash_sequencer {

namespace pio {
enum class If : unsigned { always = 0, x_not_zero_then_less = 2, y_not_zero_then_less = 4, pin = 6 };
enum class To : unsigned { pins = 0, x = 1, y = 2, pindirs = 4, isr = 6, osr = 7 };
enum class From : unsigned { pins = 0, x = 1, y = 2, null = 3, isr = 6 };
constexpr std::uint16_t word(unsigned code) { return static_cast<std::uint16_t>(code); }
constexpr std::uint16_t jmp(unsigned address, If condition = If::always, unsigned delay = 0) {
  return word(0x0000U | delay << 8 | static_cast<unsigned>(condition) << 5 | address);
}
constexpr std::uint16_t wait_for(bool level, unsigned gpio, unsigned delay = 0) {
  return word(0x2000U | delay << 8 | (level ? 0x80U : 0U) | gpio);
}
constexpr std::uint16_t in_x(unsigned bits) { return word(0x4020U | bits); }
constexpr std::uint16_t out_all(To to) { return word(0x6000U | static_cast<unsigned>(to) << 5); }
constexpr std::uint16_t push_noblock() { return 0x8000; }
constexpr std::uint16_t mov(To to, From from, bool inverted = false) {
  return word(0xa000U | static_cast<unsigned>(to) << 5 | (inverted ? 0x08U : 0U) |
              static_cast<unsigned>(from));
}
constexpr std::uint16_t set(To to, unsigned value) {
  return word(0xe000U | static_cast<unsigned>(to) << 5 | value);
}

/// Of EXECCTRL, SHIFTCTRL and PINCTRL.
constexpr std::uint32_t wrap(unsigned bottom, unsigned top) { return top << 12 | bottom << 7; }
constexpr std::uint32_t jump_pin(unsigned pin) { return pin << 24; }
inline constexpr std::uint32_t kJoinTx = 1U << 30, kJoinRx = 1U << 31, kShiftOutRight = 1U << 19,
                               kAutopull = 1U << 17;
constexpr std::uint32_t out_pins(unsigned first, unsigned count) { return count << 20 | first; }
}  // namespace pio

/// At `address`, for the edges that Y counts less one: each its delay less kEdgeCycles, and levels. Goes on
/// behind itself. One that begins at the second instruction has its first delay in X.
constexpr std::array<std::uint16_t, 4> play_edges(unsigned address) {
  using namespace pio;
  return {out_all(To::x), jmp(address + 1, If::x_not_zero_then_less), out_all(To::pins),
          jmp(address, If::y_not_zero_then_less)};  // OUT after OUT would wait for the shift register
}
inline constexpr std::uint32_t kEdgeCycles = 4;  ///< of an edge, beside its delay's count

}  // namespace strobe::flash_sequencer
