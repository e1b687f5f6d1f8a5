// One PIO block, cycle by cycle, after the RP2040's datasheet (3.2 to 3.5), and on it that of a Raspberry Pi 5's RP1 on a
// virtual clock. Cycles in which nothing can come of a machine but its count are skipped. What programs here do not use
// throws: side-set, IRQ, autopush, EXEC, clock dividers.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "common/units/time.hpp"
#include "firmware/rp1_pio/pio_block.hpp"

namespace strobe::testing {

class PioInterpreter {
 public:
  using Registers = firmware::PioBlock::Registers;
  static constexpr unsigned kMachineCount = 4;
  static constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();

  /// Of each queue, not joined: 4 on the RP2040, 8 on the RP1.
  explicit PioInterpreter(std::size_t queue_words);
  /// Levels of all pins have changed: those from that cycle on.
  std::function<void(std::int64_t cycle, std::uint32_t levels)> on_pins = [](std::int64_t, std::uint32_t) {};

  void load(std::span<const std::uint16_t> program);
  void configure(unsigned machine, const Registers& registers);
  /// Empties queues and shift registers, ends a delay.
  void restart(unsigned machine);
  void execute(unsigned machine, std::uint16_t instruction);
  void enable(unsigned machines) { enabled_ |= machines; }
  void disable(unsigned machines) { enabled_ &= ~machines; }
  bool put(unsigned machine, std::uint32_t word);
  std::optional<std::uint32_t> get(unsigned machine);
  std::size_t room(unsigned machine) const;
  /// The pins that are this block's; at first all are.
  void connect(std::uint32_t pins) {
    connected_ = pins;
    update_pads(cycle_);
  }
  /// A pin's level from outside, from this cycle on; machines see it two cycles later.
  void input(unsigned pin, bool level);

  void run_until(std::int64_t cycle);
  /// Likewise, but no further than a machine takes a word or pushes one.
  void run_until_queues_change(std::int64_t cycle);
  std::int64_t cycle() const { return cycle_; }
  std::int64_t steps() const { return steps_; }  ///< cycles that were not skipped
  unsigned address(unsigned machine) const { return machines_.at(machine).address; }
  std::uint32_t x(unsigned machine) const { return machines_.at(machine).x; }
  std::uint32_t y(unsigned machine) const { return machines_.at(machine).y; }
  std::uint32_t pins() const { return pads_; }

 private:
  static constexpr unsigned kWordBits = 32;
  struct Machine {
    Registers registers;
    unsigned address = 0;
    std::uint32_t x = 0, y = 0, isr = 0, osr = 0;
    unsigned isr_count = 0, osr_count = kWordBits, delay = 0;
    std::deque<std::uint32_t> to_machine, from_machine;
    std::optional<std::uint16_t> forced;
  };
  /// A machine that does nothing but jump in a circle.
  struct Circle {
    std::int64_t cycles = 0;
    std::uint32_t x_less = 0, y_less = 0;
    std::int64_t times = 0;  ///< it can go round before something else comes of it
  };

  void step();
  void turn(Machine& machine);
  bool carry_out(Machine& machine, std::uint16_t code);  ///< false: it stalls
  bool in(Machine& machine, std::uint16_t code) const;
  bool out(Machine& machine, std::uint16_t code);
  bool push_or_pull(Machine& machine, std::uint16_t code);
  void move(Machine& machine, std::uint16_t code);
  void set(Machine& machine, std::uint16_t code);
  void write(unsigned destination, Machine& machine, std::uint32_t value, unsigned first, unsigned count);
  std::uint32_t source(const Machine& machine, unsigned which) const;
  bool wait_is_over(const Machine& machine, std::uint16_t code) const;
  bool condition(const Machine& machine, unsigned which, std::uint32_t& x, std::uint32_t& y) const;
  static unsigned next(const Machine& machine, unsigned address);
  void prefetch(Machine& machine);
  void update_pads(std::int64_t from);

  std::int64_t quiet(const Machine& machine) const;
  Circle circle(const Machine& machine) const;
  void skip(Machine& machine, std::int64_t cycles);
  void drive(std::int64_t end, bool stop_at_queues);

  std::size_t queue_words_;
  std::array<std::uint16_t, firmware::PioBlock::kInstructionCount> program_{};
  std::array<Machine, kMachineCount> machines_;
  unsigned enabled_ = 0;
  std::int64_t cycle_ = 0, steps_ = 0;
  bool queues_changed_ = false;
  std::uint32_t out_ = 0, directions_ = 0, connected_ = ~0U, external_ = 0, pads_ = 0, seen_ = 0;
  struct Seen {
    std::int64_t cycle;
    std::uint32_t levels;
  };
  std::deque<Seen> to_be_seen_;  ///< in the synchronizers
};

/// Time of a test, passed by whoever uses it up.
class VirtualTime {
 public:
  virtual ~VirtualTime() = default;
  virtual MonoTime at() const = 0;
  virtual void pass(Duration duration) = 0;
};

/// True times of pins are those of the virtual clock, to the cycle.
class SimulatedPioBlock final : public firmware::PioBlock {
 public:
  struct PinChange {
    MonoTime time;
    unsigned pin;
    bool level;
  };

  /// time: must outlive this; its instant is cycle 0.
  explicit SimulatedPioBlock(VirtualTime& time, double drift = 23e-6, unsigned seed = 20261128);

  Duration fastest_call = microseconds(1), slowest_call = microseconds(30);  ///< drawn evenly
  Duration dma_word = nanoseconds(200);  ///< from a queue that has room to the next word in it
  bool gone = false;                     ///< calls fail
  /// Once, the next enable() takes so much longer, half of it before the machines run.
  Duration stall{};
  std::vector<PinChange> pins;  ///< of those that the block drives, in order
  std::int64_t calls = 0;

  /// From now on the virtual clock has another drift: it is steered.
  void steer(double drift);
  /// A pin's level from outside, now.
  void input(unsigned pin, bool level);
  /// Plays until now.
  void advance();
  PioInterpreter& interpreter() { return pio_; }
  /// When that cycle begins.
  MonoTime time_of(std::int64_t cycle) const;
  std::int64_t cycle_of(MonoTime time) const;

  bool load(std::span<const std::uint16_t> program) noexcept override;
  bool set_up(unsigned machine, const Registers& registers, unsigned address) noexcept override;
  bool execute(unsigned machine, std::uint16_t instruction) noexcept override;
  bool enable(unsigned machines) noexcept override;
  bool disable(unsigned machines) noexcept override;
  bool drive(unsigned pin) noexcept override;
  std::optional<std::uint32_t> get(unsigned machine) noexcept override;
  bool transfer(unsigned machine, std::span<const std::uint32_t> words) noexcept override;
  bool transferring(unsigned machine) noexcept override;
  std::optional<unsigned> queued(unsigned machine) noexcept override;

 private:
  struct Transfer {
    std::span<const std::uint32_t> words;
    std::int64_t next_at = 0;  ///< cycle
  };

  /// What the call does, somewhere within the time that it takes.
  template <typename Effect>
  auto call(Effect&& effect) noexcept -> decltype(effect());
  void run_until(std::int64_t cycle);
  void feed();
  void see(std::int64_t cycle);

  VirtualTime& time_;
  MonoTime began_;
  double drift_;
  std::mt19937 random_;
  static constexpr unsigned kQueued = 8;
  PioInterpreter pio_{kQueued};
  std::array<Transfer, kMachineCount> transfers_;
  std::uint32_t driven_ = 0, levels_ = 0;  ///< pins
};

}  // namespace strobe::testing
