#include "tests/firmware/pio_interpreter.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <string>

namespace strobe::testing {

namespace {

constexpr unsigned kAddressMask = 31;
constexpr std::uint32_t kAutopush = 1U << 16, kAutopull = 1U << 17, kInRight = 1U << 18, kOutRight = 1U << 19;
constexpr std::uint32_t kJoinTx = 1U << 30, kJoinRx = 1U << 31;

constexpr std::uint32_t field(std::uint32_t value, unsigned first, unsigned count) {
  return value >> first & ((1U << count) - 1);
}
constexpr std::uint32_t mask(unsigned count) { return count >= 32 ? ~0U : (1U << count) - 1; }
constexpr unsigned operation(std::uint16_t code) { return code >> 13; }
constexpr unsigned delay_of(std::uint16_t code) { return field(code, 8, 5); }
constexpr unsigned selector(std::uint16_t code) { return field(code, 5, 3); }
constexpr unsigned low_bits(std::uint16_t code) { return code & 31U; }
constexpr unsigned bit_count(std::uint16_t code) { return low_bits(code) == 0 ? 32 : low_bits(code); }

enum Operation : unsigned { kJmp, kWait, kIn, kOut, kPushPull, kMov, kIrq, kSet };
enum Where : unsigned { kPins, kX, kY, kNull, kPindirs, kPc, kIsr, kOsr };  // a status is where PC is

unsigned threshold(std::uint32_t shiftctrl, unsigned first) {
  const std::uint32_t bits = field(shiftctrl, first, 5);
  return bits == 0 ? 32 : bits;
}
unsigned pull_threshold(std::uint32_t shiftctrl) { return threshold(shiftctrl, 25); }
unsigned push_threshold(std::uint32_t shiftctrl) { return threshold(shiftctrl, 20); }

[[noreturn]] void unknown(const char* what) { throw std::logic_error(std::string("pio: ") + what); }

}  // namespace

PioInterpreter::PioInterpreter(std::size_t queue_words) : queue_words_(queue_words) {}

void PioInterpreter::load(std::span<const std::uint16_t> program) {
  if (program.size() > program_.size()) unknown("a program that is too long");
  std::copy(program.begin(), program.end(), program_.begin());
}

void PioInterpreter::configure(unsigned machine, const Registers& registers) {
  if (registers.clkdiv != 1U << 16) unknown("a clock divider");
  if (field(registers.pinctrl, 29, 3) != 0) unknown("side-set");
  if ((registers.shiftctrl & kAutopush) != 0) unknown("autopush");
  if ((registers.execctrl & (1U << 17 | 1U << 18)) != 0) unknown("sticky outputs");
  Machine& at = machines_.at(machine);
  if (((at.registers.shiftctrl ^ registers.shiftctrl) & (kJoinTx | kJoinRx)) != 0) {
    at.to_machine.clear();
    at.from_machine.clear();
  }
  at.registers = registers;
}

void PioInterpreter::restart(unsigned machine) {
  Machine& at = machines_.at(machine);
  at.to_machine.clear();
  at.from_machine.clear();
  at.isr = at.osr = 0;
  at.isr_count = 0;
  at.osr_count = kWordBits;
  at.delay = 0;
  at.forced.reset();
}

void PioInterpreter::execute(unsigned machine, std::uint16_t instruction) {
  if (operation(instruction) != kWait && delay_of(instruction) != 0) unknown("a delay of a forced instruction");
  machines_.at(machine).forced = instruction;
  drive(cycle_ + 1, false);
}

std::size_t PioInterpreter::room(unsigned machine) const {
  const Machine& at = machines_.at(machine);
  const std::uint32_t shift = at.registers.shiftctrl;
  const std::size_t size = (shift & kJoinRx) != 0 ? 0 : (shift & kJoinTx) != 0 ? 2 * queue_words_ : queue_words_;
  return size - at.to_machine.size();
}

bool PioInterpreter::put(unsigned machine, std::uint32_t word) {
  if (room(machine) == 0) return false;
  machines_.at(machine).to_machine.push_back(word);
  return true;
}

std::optional<std::uint32_t> PioInterpreter::get(unsigned machine) {
  auto& queue = machines_.at(machine).from_machine;
  if (queue.empty()) return std::nullopt;
  const std::uint32_t word = queue.front();
  queue.pop_front();
  return word;
}

void PioInterpreter::input(unsigned pin, bool level) {
  external_ = level ? external_ | 1U << pin : external_ & ~(1U << pin);
  update_pads(cycle_);
}

void PioInterpreter::update_pads(std::int64_t from) {
  const std::uint32_t driven = directions_ & connected_;
  const std::uint32_t pads = (out_ & driven) | (external_ & ~driven);
  if (pads == pads_) return;
  pads_ = pads;
  to_be_seen_.push_back({from + 2, pads});
  on_pins(from, pads);
}

void PioInterpreter::run_until(std::int64_t cycle) { drive(cycle, false); }
void PioInterpreter::run_until_queues_change(std::int64_t cycle) { drive(cycle, true); }

void PioInterpreter::drive(std::int64_t end, bool stop_at_queues) {
  queues_changed_ = false;
  while (cycle_ < end && !(stop_at_queues && queues_changed_)) {
    for (; !to_be_seen_.empty() && to_be_seen_.front().cycle <= cycle_; to_be_seen_.pop_front())
      seen_ = to_be_seen_.front().levels;
    std::int64_t cycles = (to_be_seen_.empty() ? end : std::min(end, to_be_seen_.front().cycle)) - cycle_;
    for (unsigned i = 0; i < kMachineCount && cycles > 0; ++i) {
      if (machines_[i].forced) cycles = 0;
      else if ((enabled_ >> i & 1U) != 0) cycles = std::min(cycles, quiet(machines_[i]));
    }
    if (cycles == 0) {
      step();
      continue;
    }
    for (unsigned i = 0; i < kMachineCount; ++i)
      if ((enabled_ >> i & 1U) != 0) skip(machines_[i], cycles);
    cycle_ += cycles;
  }
}

void PioInterpreter::step() {
  for (unsigned i = 0; i < kMachineCount; ++i)
    if ((enabled_ >> i & 1U) != 0 || machines_[i].forced) turn(machines_[i]);
  ++steps_;
  ++cycle_;
  update_pads(cycle_);
}

void PioInterpreter::turn(Machine& machine) {
  if (machine.forced) {
    const std::uint16_t code = *machine.forced;
    const unsigned address = machine.address;
    if (!carry_out(machine, code)) return prefetch(machine);
    machine.forced.reset();
    // It does not go on by itself, but where a jump goes to.
    const bool to_pc = (operation(code) == kMov || operation(code) == kOut) && selector(code) == kPc;
    const bool jumped = operation(code) == kJmp && (selector(code) == 0 || machine.address != next(machine, address));
    if (!to_pc && !jumped) machine.address = address;
    if (operation(code) != kOut) prefetch(machine);
    return;
  }
  if (machine.delay > 0) {
    --machine.delay;
    return prefetch(machine);
  }
  const std::uint16_t code = program_[machine.address];
  if (carry_out(machine, code)) machine.delay = delay_of(code);
  if (operation(code) != kOut) prefetch(machine);
}

bool PioInterpreter::carry_out(Machine& machine, std::uint16_t code) {
  const unsigned before = machine.address;
  bool done = true;
  switch (operation(code)) {
    case kJmp:
      if (!condition(machine, selector(code), machine.x, machine.y)) break;
      machine.address = low_bits(code);
      return true;
    case kWait:
      done = wait_is_over(machine, code);
      break;
    case kIn:
      done = in(machine, code);
      break;
    case kOut:
      done = out(machine, code);
      if (done && selector(code) == kPc) return true;
      break;
    case kPushPull:
      done = push_or_pull(machine, code);
      break;
    case kMov:
      move(machine, code);
      if (selector(code) == kPc) return true;
      break;
    case kSet:
      set(machine, code);
      break;
    default:
      unknown("IRQ");
  }
  if (!done) return false;
  machine.address = next(machine, before);
  return true;
}

unsigned PioInterpreter::next(const Machine& machine, unsigned address) {
  const std::uint32_t exec = machine.registers.execctrl;
  return address == field(exec, 12, 5) ? field(exec, 7, 5) : (address + 1) & kAddressMask;
}

bool PioInterpreter::condition(const Machine& machine, unsigned which, std::uint32_t& x, std::uint32_t& y) const {
  switch (which) {
    case 0:
      return true;
    case 1:
      return x == 0;
    case 2:
      return x-- != 0;
    case 3:
      return y == 0;
    case 4:
      return y-- != 0;
    case 5:
      return x != y;
    case 6:
      return (seen_ >> field(machine.registers.execctrl, 24, 5) & 1U) != 0;
    default:
      return machine.osr_count < pull_threshold(machine.registers.shiftctrl);
  }
}

bool PioInterpreter::wait_is_over(const Machine& machine, std::uint16_t code) const {
  const unsigned from = field(code, 5, 2);
  if (from > 1) unknown("WAIT IRQ");
  const unsigned base = from == 0 ? 0 : field(machine.registers.pinctrl, 15, 5);
  return (seen_ >> ((base + low_bits(code)) & 31U) & 1U) == field(code, 7, 1);
}

std::uint32_t PioInterpreter::source(const Machine& machine, unsigned which) const {
  switch (which) {
    case kPins:
      return std::rotr(seen_, static_cast<int>(field(machine.registers.pinctrl, 15, 5)));
    case kX:
      return machine.x;
    case kY:
      return machine.y;
    case kNull:
      return 0;
    case kIsr:
      return machine.isr;
    case kOsr:
      return machine.osr;
    default:
      unknown("this source");
  }
}

bool PioInterpreter::in(Machine& machine, std::uint16_t code) const {
  const unsigned count = bit_count(code);
  const std::uint32_t bits = source(machine, selector(code)) & mask(count);
  if (count == 32) machine.isr = bits;
  else if ((machine.registers.shiftctrl & kInRight) != 0) machine.isr = machine.isr >> count | bits << (32 - count);
  else machine.isr = machine.isr << count | bits;
  machine.isr_count = std::min(kWordBits, machine.isr_count + count);
  return true;
}

/// An empty shift register is not filled and used in one cycle.
bool PioInterpreter::out(Machine& machine, std::uint16_t code) {
  const std::uint32_t shift = machine.registers.shiftctrl;
  if ((shift & kAutopull) != 0 && machine.osr_count >= pull_threshold(shift)) {
    prefetch(machine);
    return false;
  }
  const unsigned count = bit_count(code);
  const bool right = (shift & kOutRight) != 0;
  const std::uint32_t value = (right || count == 32 ? machine.osr : machine.osr >> (32 - count)) & mask(count);
  machine.osr = count == 32 ? 0 : right ? machine.osr >> count : machine.osr << count;
  machine.osr_count = std::min(kWordBits, machine.osr_count + count);
  const std::uint32_t pins = machine.registers.pinctrl;
  write(selector(code), machine, value, field(pins, 0, 5), field(pins, 20, 6));
  if (selector(code) == kIsr) machine.isr_count = count;
  prefetch(machine);
  return true;
}

void PioInterpreter::prefetch(Machine& machine) {
  const std::uint32_t shift = machine.registers.shiftctrl;
  if ((shift & kAutopull) == 0 || machine.osr_count < pull_threshold(shift) || machine.to_machine.empty()) return;
  machine.osr = machine.to_machine.front();
  machine.to_machine.pop_front();
  machine.osr_count = 0;
  queues_changed_ = true;
}

bool PioInterpreter::push_or_pull(Machine& machine, std::uint16_t code) {
  const bool pulls = (code & 0x80) != 0, only_at_threshold = (code & 0x40) != 0, blocks = (code & 0x20) != 0;
  const std::uint32_t shift = machine.registers.shiftctrl;
  if (pulls) {
    const bool needed = machine.osr_count >= pull_threshold(shift);
    if (!needed && (only_at_threshold || (shift & kAutopull) != 0)) return true;
    if (machine.to_machine.empty()) {
      if (blocks) return false;
      machine.osr = machine.x;
    } else {
      machine.osr = machine.to_machine.front();
      machine.to_machine.pop_front();
      queues_changed_ = true;
    }
    machine.osr_count = 0;
    return true;
  }
  if (only_at_threshold && machine.isr_count < push_threshold(shift)) return true;
  const std::size_t size = (shift & kJoinTx) != 0 ? 0 : (shift & kJoinRx) != 0 ? 2 * queue_words_ : queue_words_;
  if (machine.from_machine.size() < size) {
    machine.from_machine.push_back(machine.isr);
    queues_changed_ = true;
  } else if (blocks) {
    return false;
  }
  machine.isr = 0;
  machine.isr_count = 0;
  return true;
}

void PioInterpreter::move(Machine& machine, std::uint16_t code) {
  std::uint32_t value = source(machine, code & 7U);
  const unsigned change = field(code, 3, 2);
  if (change == 1) value = ~value;
  if (change > 1) unknown("a reversed MOV");
  if (selector(code) == kNull || selector(code) == kPindirs) unknown("a MOV to there");
  const std::uint32_t pins = machine.registers.pinctrl;
  write(selector(code), machine, value, field(pins, 0, 5), field(pins, 20, 6));
  if (selector(code) == kIsr) machine.isr_count = 0;
  if (selector(code) == kOsr) machine.osr_count = 0;
}

void PioInterpreter::set(Machine& machine, std::uint16_t code) {
  const std::uint32_t pins = machine.registers.pinctrl;
  write(selector(code), machine, low_bits(code), field(pins, 5, 5), field(pins, 26, 3));
}

/// Of several that write a pin in one cycle the last one wins, the machine with the highest number.
void PioInterpreter::write(unsigned destination, Machine& machine, std::uint32_t value, unsigned first, unsigned count) {
  const std::uint32_t which = std::rotl(mask(count), static_cast<int>(first));
  const std::uint32_t levels = std::rotl(value & mask(count), static_cast<int>(first));
  switch (destination) {
    case kPins:
      out_ = (out_ & ~which) | levels;
      return;
    case kX:
      machine.x = value;
      return;
    case kY:
      machine.y = value;
      return;
    case kNull:
      return;
    case kPindirs:
      directions_ = (directions_ & ~which) | levels;
      return;
    case kPc:
      machine.address = value & kAddressMask;
      return;
    case kIsr:
      machine.isr = value;
      return;
    default:
      machine.osr = value;
  }
}

/// For how many cycles nothing comes of it while no pin and no queue changes.
std::int64_t PioInterpreter::quiet(const Machine& machine) const {
  const std::uint32_t shift = machine.registers.shiftctrl;
  const bool wants = (shift & kAutopull) != 0 && machine.osr_count >= pull_threshold(shift);
  if (wants && !machine.to_machine.empty()) return 0;
  if (machine.delay > 0) return machine.delay;
  const std::uint16_t code = program_[machine.address];
  switch (operation(code)) {
    case kJmp: {
      const Circle around = circle(machine);
      return around.times == kForever ? kForever : around.cycles * around.times;
    }
    case kWait:
      return wait_is_over(machine, code) ? 0 : kForever;
    case kOut:
      return wants ? kForever : 0;
    case kPushPull:
      return (code & 0xa0) == 0xa0 && machine.to_machine.empty() && !((code & 0x40) != 0 && !wants) ? kForever : 0;
    case kMov: {  // zeros again and again
      const std::uint32_t exec = machine.registers.execctrl, pins = machine.registers.pinctrl;
      const std::uint32_t which = std::rotl(mask(field(pins, 20, 6)), static_cast<int>(field(pins, 0, 5)));
      const bool alone = field(exec, 12, 5) == machine.address && field(exec, 7, 5) == machine.address;
      return code == 0xa003 && alone && (out_ & which) == 0 ? kForever : 0;
    }
    default:
      return 0;
  }
}

PioInterpreter::Circle PioInterpreter::circle(const Machine& machine) const {
  constexpr int kLongest = 8;
  std::uint32_t x = machine.x, y = machine.y;
  unsigned address = machine.address;
  Circle around;
  bool compares = false;
  for (int i = 0; i < kLongest; ++i) {
    const std::uint16_t code = program_[address];
    const unsigned which = selector(code);
    if (operation(code) != kJmp) return {};
    if ((which == 2 && x == 0) || (which == 4 && y == 0)) return {};  // it goes elsewhere, and wraps
    compares = compares || which == 1 || which == 3 || which == 5;
    address = condition(machine, which, x, y) ? low_bits(code) : next(machine, address);
    around.cycles += 1 + delay_of(code);
    if (address != machine.address) continue;
    around.x_less = machine.x - x;
    around.y_less = machine.y - y;
    if (around.x_less == 0 && around.y_less == 0) {
      around.times = kForever;
      return around;
    }
    if (compares) return {};
    around.times = kForever;
    if (around.x_less != 0) around.times = std::min<std::int64_t>(around.times, machine.x / around.x_less);
    if (around.y_less != 0) around.times = std::min<std::int64_t>(around.times, machine.y / around.y_less);
    return around;
  }
  return {};
}

void PioInterpreter::skip(Machine& machine, std::int64_t cycles) {
  if (machine.delay > 0) {
    machine.delay -= static_cast<unsigned>(cycles);
    return;
  }
  if (operation(program_[machine.address]) != kJmp) return;
  const Circle around = circle(machine);
  const auto times = static_cast<std::uint32_t>(cycles / around.cycles);
  machine.x -= times * around.x_less;
  machine.y -= times * around.y_less;
  for (std::int64_t rest = cycles % around.cycles; rest > 0; --rest) turn(machine);
}

}  // namespace strobe::testing
