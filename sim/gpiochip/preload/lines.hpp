// Taking, configuring and naming lines: what requests of uAPI v1 and v2 have in common. With the chip's lock
// held, if not said otherwise.
#pragma once

#include <cstdint>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/ownership.hpp"
#include "sim/gpiochip/state.hpp"

namespace strobe::sim::gpio {

enum class Direction { as_is, input, output };

struct LineSetting {
  std::uint32_t flags = 0;  ///< bits of ConfigWord
  Direction direction = Direction::as_is;
  unsigned value = 0;  ///< logical, of an output
};

/// Sets flags and direction of a line in one store together with `owner`, and only then touches the pin: at
/// no instant is a line driven that would not be released if its owner died.
void configure_line(State& state, std::uint32_t line, const LineSetting& setting, std::uint32_t owner,
                    std::int64_t now_ns);

/// -EINVAL if a bias is asked for of a chip that refuses it.
int check_bias(const State& state, std::uint32_t flags);
/// -EBUSY if the line has an owner.
int check_free(State& state, const ChipLock& lock, std::uint32_t line);
/// What the kernel shows as the line's owner.
void name_owner(State& state, std::uint32_t line, const char* consumer);

/// A slot for a new handle or v2 request: there are as many as lines, and each has at least one line. -EBUSY
/// if there is none.
int free_slot(State& state, const ChipLock& lock, std::uint32_t& slot);

/// Releases the line if its owner is gone. Without the lock.
void reap_before_look(std::uint32_t line);

/// Hot calls skip the checked copy, which costs a system call; a wild pointer there is a fault.
inline bool plausible(const void* user) { return reinterpret_cast<std::uintptr_t>(user) >= 4096; }

/// Discards records that the previous owner of a FIFO did not read.
void drain(int fd);

/// The caller gets the descriptor; it is closed if the lines could not be had.
int finish_request(State& state, int result, int fd, int& given);

// From a logical value to what the chip does to the pin.

constexpr unsigned physical(std::uint32_t config, unsigned logical) {
  return (logical != 0) != ((config & ConfigWord::kActiveLow) != 0) ? 1 : 0;
}

/// Open drain and open source are emulated as the kernel does it: the undriven level is "not driven".
constexpr PinEdit output_edit(std::uint32_t config, unsigned logical) {
  const unsigned value = physical(config, logical);
  if ((config & ConfigWord::kOpenDrain) != 0 && value == 1) return float_edit();
  if ((config & ConfigWord::kOpenSource) != 0 && value == 0) return float_edit();
  return drive_edit(value);
}

}  // namespace strobe::sim::gpio
