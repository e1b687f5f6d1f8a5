#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "tests/firmware/pio_interpreter.hpp"

namespace strobe::testing {

SimulatedPioBlock::SimulatedPioBlock(VirtualTime& time, double drift, unsigned seed)
    : time_(time), began_(time.at()), drift_(drift), random_(seed) {
  pio_.connect(0);
  pio_.on_pins = [this](std::int64_t cycle, std::uint32_t) { see(cycle); };
}

MonoTime SimulatedPioBlock::time_of(std::int64_t cycle) const {
  return began_ + Duration{std::llround(static_cast<double>(cycle * kCycle_ns) * (1.0 + drift_))};
}

void SimulatedPioBlock::steer(double drift) {
  advance();
  const MonoTime now = time_of(pio_.cycle());
  drift_ = drift;
  began_ += now - time_of(pio_.cycle());
}

std::int64_t SimulatedPioBlock::cycle_of(MonoTime time) const {
  return static_cast<std::int64_t>(
      std::floor(static_cast<double>((time - began_).count()) / static_cast<double>(kCycle_ns) / (1.0 + drift_)));
}

void SimulatedPioBlock::see(std::int64_t cycle) {
  const std::uint32_t levels = pio_.pins() & driven_;
  for (std::uint32_t changed = levels ^ levels_; changed != 0; changed &= changed - 1) {
    const auto pin = static_cast<unsigned>(std::countr_zero(changed));
    pins.push_back({time_of(cycle), pin, (levels >> pin & 1U) != 0});
  }
  levels_ = levels;
}

void SimulatedPioBlock::feed() {
  for (unsigned machine = 0; machine < kMachineCount; ++machine) {
    Transfer& transfer = transfers_[machine];
    if (transfer.words.empty()) continue;
    const std::int64_t asked = pio_.cycle() + dma_word / nanoseconds(kCycle_ns);
    if (pio_.room(machine) == 0) {
      transfer.next_at = PioInterpreter::kForever;
    } else if (transfer.next_at == PioInterpreter::kForever) {
      transfer.next_at = asked;
    } else if (transfer.next_at <= pio_.cycle()) {
      pio_.put(machine, transfer.words.front());
      transfer.words = transfer.words.subspan(1);
      transfer.next_at = asked;
    }
  }
}

void SimulatedPioBlock::run_until(std::int64_t cycle) {
  while (pio_.cycle() < cycle) {
    feed();
    std::int64_t next = cycle;
    for (unsigned machine = 0; machine < kMachineCount; ++machine) {
      const Transfer& transfer = transfers_[machine];
      if (!transfer.words.empty() && pio_.room(machine) > 0) next = std::min(next, transfer.next_at);
    }
    pio_.run_until_queues_change(next);
  }
  feed();
}

void SimulatedPioBlock::advance() { run_until(cycle_of(time_.at())); }

void SimulatedPioBlock::input(unsigned pin, bool level) {
  advance();
  pio_.input(pin, level);
}

template <typename Effect>
auto SimulatedPioBlock::call(Effect&& effect) noexcept -> decltype(effect()) {
  ++calls;
  std::uniform_int_distribution<std::int64_t> whole(fastest_call.count(), slowest_call.count());
  const Duration length{whole(random_)};
  const Duration before{std::uniform_int_distribution<std::int64_t>(0, length.count())(random_)};
  time_.pass(before);
  advance();
  auto result = gone ? decltype(effect()){} : effect();
  time_.pass(length - before);
  return result;
}

bool SimulatedPioBlock::load(std::span<const std::uint16_t> program) noexcept {
  return call([&] {
    pio_.load(program);
    return true;
  });
}

bool SimulatedPioBlock::set_up(unsigned machine, const Registers& registers, unsigned address) noexcept {
  return call([&] {
    pio_.disable(1U << machine);
    pio_.configure(machine, registers);
    pio_.restart(machine);
    pio_.execute(machine, static_cast<std::uint16_t>(address));
    return true;
  });
}

bool SimulatedPioBlock::execute(unsigned machine, std::uint16_t instruction) noexcept {
  return call([&] {
    pio_.execute(machine, instruction);
    return true;
  });
}

bool SimulatedPioBlock::enable(unsigned machines) noexcept {
  const Duration half = std::exchange(stall, Duration{}) / 2;
  time_.pass(half);
  const bool done = call([&] {
    pio_.enable(machines);
    return true;
  });
  time_.pass(half);
  return done;
}

bool SimulatedPioBlock::disable(unsigned machines) noexcept {
  return call([&] {
    pio_.disable(machines);
    return true;
  });
}

bool SimulatedPioBlock::drive(unsigned pin) noexcept {
  return call([&] {
    driven_ |= 1U << pin;
    pio_.connect(driven_);
    return true;
  });
}

std::optional<std::uint32_t> SimulatedPioBlock::get(unsigned machine) noexcept {
  return call([&] { return pio_.get(machine); });
}

bool SimulatedPioBlock::transfer(unsigned machine, std::span<const std::uint32_t> words) noexcept {
  return call([&] {
    if (!transfers_.at(machine).words.empty()) return false;
    while (!words.empty() && pio_.put(machine, words.front())) words = words.subspan(1);
    transfers_[machine] = {words, PioInterpreter::kForever};
    return true;
  });
}

bool SimulatedPioBlock::transferring(unsigned machine) noexcept {
  return call([&] { return !transfers_.at(machine).words.empty() || pio_.room(machine) < kQueued; });
}

std::optional<unsigned> SimulatedPioBlock::queued(unsigned machine) noexcept {
  return call([&] { return std::optional<unsigned>(kQueued - static_cast<unsigned>(pio_.room(machine))); });
}

}  // namespace strobe::testing
