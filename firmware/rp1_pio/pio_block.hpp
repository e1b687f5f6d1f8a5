// Port: the PIO block of a Raspberry Pi 5's RP1 as a process reaches it: instruction memory for 32, four
// state machines, each with a queue of words either way. Machine, registers and instructions are those of the
// RP2040 (its datasheet, 3.2 to 3.7); the RP1 runs them at 200 MHz. Every call is a message to the RP1's own
// firmware, takes 1 to some 10 us, and may sleep meanwhile.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace strobe::firmware {

/// Not thread-safe, but for execute(). Calls return false or nullopt if the RP1 refused or is gone.
class PioBlock {
 public:
  static constexpr unsigned kMachineCount = 4;
  static constexpr unsigned kInstructionCount = 32;
  static constexpr unsigned kPinCount = 28;
  static constexpr std::int64_t kCycle_ns = 5;

  /// A machine's registers.
  struct Registers {
    std::uint32_t clkdiv = 1U << 16;
    std::uint32_t execctrl = 0;
    std::uint32_t shiftctrl = 0;
    std::uint32_t pinctrl = 0;
  };

  virtual ~PioBlock() = default;
  /// From address 0 on.
  virtual bool load(std::span<const std::uint16_t> program) noexcept = 0;
  /// Stops the machine, empties its queues, and sets it to that address.
  virtual bool set_up(unsigned machine, const Registers& registers, unsigned address) noexcept = 0;
  /// Once, now, in place of what the machine, enabled or not, would do next. Async-signal-safe, from any
  /// thread and process that has the block.
  virtual bool execute(unsigned machine, std::uint16_t instruction) noexcept = 0;
  /// Bits of `machines`: 1 << machine. All in the same cycle.
  virtual bool enable(unsigned machines) noexcept = 0;
  virtual bool disable(unsigned machines) noexcept = 0;
  /// Where a pin's level comes from: this block.
  virtual bool drive(unsigned pin) noexcept = 0;

  /// The oldest word from the machine; nullopt as well if there is none.
  virtual std::optional<std::uint32_t> get(unsigned machine) noexcept = 0;
  /// Words to the machine, by DMA as it takes them, without waiting for that; its queue is full, or holds
  /// them all, once this has returned. They must stay as they are while transferring(). One at a time for
  /// each machine, and after set_up().
  virtual bool transfer(unsigned machine, std::span<const std::uint32_t> words) noexcept = 0;
  /// Whether words of a transfer may still come to the machine, or wait for it. A transfer cannot be called
  /// back: the machine takes all of it.
  virtual bool transferring(unsigned machine) noexcept = 0;
  /// Words that wait for the machine.
  virtual std::optional<unsigned> queued(unsigned machine) noexcept = 0;
};

}  // namespace strobe::firmware
