// The interpreter of PIO that stands in for a Raspberry Pi 5's, against what the RP2040's datasheet says.
#include "tests/firmware/pio_interpreter.hpp"

#include <array>
#include <cstdio>
#include <vector>

#include "firmware/sequencer/pio_programs.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::testing;
namespace pio = strobe::flash_sequencer::pio;

namespace {

using pio::jump_pin, pio::kAutopull, pio::kJoinRx, pio::kJoinTx, pio::kShiftOutRight, pio::out_pins, pio::wrap;
constexpr std::uint32_t set_pins(unsigned first, unsigned count) { return count << 26 | first << 5; }
constexpr std::uint16_t delayed(std::uint16_t code, unsigned cycles) {
  return static_cast<std::uint16_t>(code | cycles << 8);
}
constexpr std::uint16_t kPull = 0x80a0, kPush = 0x8020;
constexpr std::uint16_t mov(unsigned to, bool inverted, unsigned from) {
  return static_cast<std::uint16_t>(0xa000U | to << 5 | (inverted ? 8U : 0U) | from);
}

struct Block {
  struct Level {
    std::int64_t cycle;
    std::uint32_t levels;
  };
  PioInterpreter pio;
  std::vector<Level> seen;
  explicit Block(std::size_t queue_words = 4) : pio(queue_words) {
    pio.on_pins = [this](std::int64_t cycle, std::uint32_t levels) { seen.push_back({cycle, levels}); };
  }
  template <std::size_t size>
  void load(const std::array<std::uint16_t, size>& code) {
    pio.load(code);
  }
  void set_up(unsigned machine, const PioInterpreter::Registers& registers, unsigned address = 0) {
    pio.configure(machine, registers);
    pio.restart(machine);
    pio.execute(machine, static_cast<std::uint16_t>(address));
  }
  /// Pins driven from now on, low.
  void drive(unsigned machine, unsigned first, unsigned count) {
    PioInterpreter::Registers registers;
    registers.shiftctrl = kShiftOutRight;
    registers.pinctrl = out_pins(first, count);
    set_up(machine, registers);
    pio.execute(machine, mov(7, true, 3));
    pio.execute(machine, pio::out_all(pio::To::pindirs));
  }
  void run(std::int64_t cycles) { pio.run_until(pio.cycle() + cycles); }
};

}  // namespace

TEST_GROUP(PioInterpreter){};

TEST(PioInterpreter, GivesTheSquareWaveOfTheDatasheetAQuarterOfTheClock) {
  Block block;
  block.load(std::array<std::uint16_t, 4>{pio::set(pio::To::pindirs, 1), delayed(pio::set(pio::To::pins, 1), 1),
                                          pio::set(pio::To::pins, 0), pio::jmp(1)});
  block.set_up(0, {.execctrl = wrap(0, 31), .pinctrl = set_pins(5, 1)});
  block.pio.enable(1);
  block.run(41);
  CHECK_EQUAL(20u, block.seen.size());  // ten periods of four cycles, after one for the direction
  for (std::size_t i = 1; i < block.seen.size(); ++i) CHECK_EQUAL(2, block.seen[i].cycle - block.seen[i - 1].cycle);
  CHECK_EQUAL(1u << 5, block.seen[0].levels);
}

TEST(PioInterpreter, AddsAsTheDatasheetsExampleDoes) {
  // 3.6.9: adds two words by counting.
  const std::array<std::uint16_t, 9> addition{kPull,
                                              mov(1, true, 7),
                                              kPull,
                                              mov(2, false, 7),
                                              pio::jmp(6),
                                              pio::jmp(6, pio::If::x_not_zero_then_less),
                                              pio::jmp(5, pio::If::y_not_zero_then_less),
                                              mov(6, true, 1),
                                              kPush};
  for (const auto& [a, b] : {std::pair{2U, 3U}, {0U, 0U}, {7U, 0U}, {0U, 1'000'000'000U}, {4'000'000'000U, 400'000'000U},
                             {~0U, 1'000U}, {~0U, ~0U}}) {
    Block block;
    block.load(addition);
    block.set_up(2, {.execctrl = wrap(0, 8)});
    CHECK_TRUE(block.pio.put(2, a));
    CHECK_TRUE(block.pio.put(2, b));
    block.pio.enable(1 << 2);
    block.run(2 * std::int64_t{b} + 20);
    const auto sum = block.pio.get(2);
    CHECK(sum.has_value());
    CHECK_EQUAL(a + b, *sum);
    CHECK(block.pio.steps() < 100);  // it does not count itself
  }
}

TEST(PioInterpreter, SeesAnInputAfterTwoCyclesAndWaitsForIt) {
  Block block;
  block.load(std::array<std::uint16_t, 3>{pio::wait_for(true, 7, 3), pio::set(pio::To::pins, 1), pio::jmp(2)});
  block.drive(0, 1, 1);
  block.set_up(0, {.execctrl = wrap(0, 31), .pinctrl = set_pins(1, 1)});
  block.pio.enable(1);
  block.run(100);
  const std::int64_t raised = block.pio.cycle();
  block.pio.input(7, true);
  block.run(100);
  // Two cycles of synchronizers, WAIT's, three of its delay, SET's; the pin from the next one on.
  CHECK_EQUAL(raised + 2 + 1 + 3 + 1, block.seen.back().cycle);
}

TEST(PioInterpreter, ShiftsOutWordAfterWordWithoutAGap) {
  for (const bool right : {true, false}) {
    Block block;
    block.load(std::array<std::uint16_t, 1>{0x6001});  // out pins, 1
    block.drive(0, 3, 1);
    block.set_up(0, {.execctrl = wrap(0, 0), .shiftctrl = kAutopull | (right ? kShiftOutRight : 0), .pinctrl = out_pins(3, 1)});
    const std::array words{0x12345678U, 0x9abcdef0U, 0xfedcba98U};
    for (const std::uint32_t word : words) CHECK_TRUE(block.pio.put(0, word));
    block.pio.enable(1);
    block.run(1);  // the empty register is filled, and not shifted out of
    for (const std::uint32_t word : words) {
      for (int bit = 0; bit < 32; ++bit) {
        block.run(1);
        CHECK_EQUAL(word >> (right ? bit : 31 - bit) & 1U, block.pio.pins() >> 3 & 1U);
      }
    }
    const std::int64_t before = block.pio.steps();
    block.run(1'000'000);  // it stalls, and keeps its pin
    CHECK_EQUAL(before, block.pio.steps());
  }
}

TEST(PioInterpreter, LetsTheHighestMachineWriteAPinOfSeveralInOneCycle) {
  Block block;
  block.load(std::array<std::uint16_t, 4>{pio::set(pio::To::pins, 3), pio::jmp(0), pio::mov(pio::To::pins, pio::From::null), pio::jmp(3)});
  block.drive(0, 4, 2);
  block.set_up(1, {.execctrl = wrap(0, 31), .pinctrl = set_pins(4, 2)});
  block.set_up(3, {.execctrl = wrap(2, 2), .pinctrl = out_pins(4, 1)}, 2);
  block.pio.enable(1 << 1 | 1 << 3);  // in the same cycle
  block.run(10);
  CHECK_EQUAL(1u, block.seen.size());
  CHECK_EQUAL(2u << 4, block.seen[0].levels);
  block.pio.disable(1 << 3);
  block.run(2);
  CHECK_EQUAL(3u << 4, block.seen.back().levels);
}

TEST(PioInterpreter, HasQueuesOfFourWordsThatCanBeJoined) {
  for (const auto& [depth, shift, words] :
       {std::tuple{4U, 0U, 4U}, {4U, kJoinTx, 8U}, {4U, kJoinRx, 0U}, {8U, 0U, 8U}, {8U, kJoinTx, 16U}}) {
    Block block(depth);
    block.set_up(0, {.shiftctrl = shift});
    unsigned put = 0;
    while (block.pio.put(0, put)) ++put;
    CHECK_EQUAL(words, put);
  }
  for (const auto& [shift, words] : {std::pair{0U, 4U}, {kJoinRx, 8U}, {kJoinTx, 0U}}) {
    Block block;
    block.load(std::array<std::uint16_t, 3>{pio::set(pio::To::x, 9), mov(6, false, 1), pio::push_noblock()});
    block.set_up(0, {.execctrl = wrap(0, 2), .shiftctrl = shift});
    block.pio.enable(1);
    block.run(100);
    unsigned got = 0;
    while (const auto word = block.pio.get(0)) {
      CHECK_EQUAL(9u, *word);
      ++got;
    }
    CHECK_EQUAL(words, got);
  }
}

TEST(PioInterpreter, CarriesOutWhatIsForcedWhateverTheMachineDoes) {
  Block block;
  block.load(std::array<std::uint16_t, 4>{pio::wait_for(true, 9), delayed(pio::jmp(1), 31), pio::set(pio::To::pins, 1),
                                          pio::jmp(3)});
  block.drive(0, 0, 1);
  block.set_up(0, {.execctrl = wrap(0, 31), .pinctrl = set_pins(0, 1)});
  block.pio.execute(0, pio::set(pio::To::y, 17));  // it is not enabled
  CHECK_EQUAL(17u, block.pio.y(0));
  CHECK_EQUAL(0u, block.pio.address(0));
  block.pio.enable(1);
  block.run(5);
  block.pio.execute(0, mov(1, false, 2));  // it waits
  CHECK_EQUAL(17u, block.pio.x(0));
  CHECK_EQUAL(0u, block.pio.address(0));
  block.pio.execute(0, pio::jmp(2));
  block.run(1);
  CHECK_EQUAL(1u, block.pio.pins());
}

TEST(PioInterpreter, SkipsNothingThatWouldHaveCome) {
  constexpr unsigned kSeed = 20261128;
  std::printf("seed %u\n", kSeed);
  std::mt19937 random(kSeed);
  const auto drawn = [&random](unsigned below) { return static_cast<unsigned>(random() % below); };
  std::int64_t steps = 0, cycles = 0;
  for (int program = 0; program < 500; ++program) {
    std::array<std::uint16_t, 8> code{};
    for (std::uint16_t& each : code) {
      const unsigned kind = drawn(10), delay = drawn(4) == 0 ? drawn(32) : 0;
      const std::uint16_t plain = kind < 6   ? static_cast<std::uint16_t>(drawn(7) << 5 | drawn(8))
                                  : kind < 7 ? pio::wait_for(drawn(2) != 0, 8 + drawn(2))
                                  : kind < 8 ? pio::out_all(drawn(2) != 0 ? pio::To::x : pio::To::pins)
                                  : kind < 9 ? pio::set(drawn(2) != 0 ? pio::To::x : pio::To::pins, drawn(32))
                                             : mov(drawn(3), drawn(4) == 0, drawn(4));
      each = delayed(plain, delay);
    }
    Block skips, walks;
    for (Block* block : {&skips, &walks}) {
      block->load(code);
      block->drive(0, 0, 4);
      for (unsigned machine = 0; machine < 4; ++machine) {
        block->set_up(machine, {.execctrl = wrap(0, 7) | jump_pin(8 + machine % 2),
                                .shiftctrl = kAutopull | kShiftOutRight,
                                .pinctrl = out_pins(machine, 2) | set_pins(2 - machine / 2, 2)},
                      2 * machine);
        block->pio.enable(1U << machine);
      }
    }
    for (int i = 0; i < 30; ++i) {
      const std::int64_t end = skips.pio.cycle() + drawn(200);
      skips.pio.run_until(end);
      while (walks.pio.cycle() < end) walks.pio.run_until(walks.pio.cycle() + 1);
      const unsigned machine = drawn(4), word = drawn(100), pin = 8 + drawn(2);
      const bool level = drawn(2) != 0, puts = drawn(2) != 0;
      for (Block* block : {&skips, &walks}) {
        if (puts) block->pio.put(machine, word);
        block->pio.input(pin, level);
      }
    }
    CHECK_EQUAL(walks.seen.size(), skips.seen.size());
    for (std::size_t i = 0; i < walks.seen.size(); ++i) {
      CHECK_EQUAL(walks.seen[i].cycle, skips.seen[i].cycle);
      CHECK_EQUAL(walks.seen[i].levels, skips.seen[i].levels);
    }
    for (unsigned machine = 0; machine < 4; ++machine) {
      CHECK_EQUAL(walks.pio.address(machine), skips.pio.address(machine));
      CHECK_EQUAL(walks.pio.x(machine), skips.pio.x(machine));
      CHECK_EQUAL(walks.pio.y(machine), skips.pio.y(machine));
    }
    steps += skips.pio.steps();
    cycles += skips.pio.cycle();
  }
  CHECK(2 * steps < cycles);  // some it does skip
}

// The programs of the RP2040, which the emulator's PIO plays to the cycle (tests/sequencer): what this one makes of them
// must be the same.

TEST(PioInterpreter, PlaysTheFlashSequencersTracksToTheCycle) {
  using namespace strobe::sequencer::outputs_program;
  using strobe::flash_sequencer::kEdgeCycles;
  Block block;
  block.pio.load(kCode);
  block.drive(1, 4, 2);
  constexpr unsigned kStart = strobe::sequencer::kStartPin;
  block.set_up(1, {.execctrl = wrap(0, 31), .shiftctrl = kAutopull | kShiftOutRight | kJoinTx, .pinctrl = out_pins(4, 2)}, kPlay);
  const std::vector<std::uint32_t> delays{16, 17, 100, 16, 1'000'003, 25'000, 90'000'000, 16};
  block.pio.put(1, static_cast<std::uint32_t>(delays.size()) - 1);
  block.pio.enable(1 << 1);
  block.run(50);
  block.seen.clear();
  const std::int64_t start = block.pio.cycle();
  block.pio.input(kStart, true);
  std::size_t fed = 0;
  std::vector<std::uint32_t> words;
  for (std::size_t i = 0; i < delays.size(); ++i) {
    words.push_back(delays[i] - (i == 0 ? kFirstCycles : kEdgeCycles));
    words.push_back(static_cast<std::uint32_t>(i + 1) % 4);
  }
  std::int64_t due = start;
  for (const std::uint32_t delay : delays) due += delay;
  while (block.pio.cycle() < due + 10) {
    while (fed < words.size() && block.pio.put(1, words[fed])) ++fed;
    block.pio.run_until_queues_change(due + 10);
  }
  CHECK_EQUAL(delays.size() + 1, block.seen.size());  // and START's own
  due = start + 1;                                    // a pin changes in the cycle after the instruction's
  for (std::size_t i = 0; i < delays.size(); ++i) {
    due += delays[i];
    CHECK_EQUAL(due, block.seen[i + 1].cycle);
  }
  CHECK_EQUAL(kOver, block.pio.address(1));
  CHECK(block.pio.steps() < 400);
}

TEST(PioInterpreter, CutsAsTheFlashSequencersWatchersDo) {
  using namespace strobe::sequencer::outputs_program;
  for (const auto& [low_for, cuts] : {std::pair{60, false}, {70, true}}) {
    Block block;
    block.pio.load(kCode);
    block.drive(2, 4, 2);
    block.set_up(2, {.execctrl = wrap(kCut, kCut) | jump_pin(9), .shiftctrl = kShiftOutRight, .pinctrl = out_pins(4, 2)});
    block.set_up(0, {.pinctrl = set_pins(4, 2)});
    block.pio.input(9, true);
    block.pio.run_until(10);
    block.pio.enable(1 << 2);
    block.pio.execute(0, pio::set(pio::To::pins, 3));
    block.run(200'000'000);
    const std::int64_t low = block.pio.cycle();
    block.pio.input(9, false);
    block.run(low_for);
    block.pio.input(9, true);
    block.run(1000);
    CHECK_EQUAL(cuts ? 0u : 3u, block.pio.pins() >> 4 & 3u);
    if (!cuts) continue;
    std::int64_t cut = 0;
    for (const auto& level : block.seen)
      if (cut == 0 && level.cycle > low && (level.levels >> 4 & 3u) == 0) cut = level.cycle;
    // Two synchronizers, JMP PIN, SET, 31 times two of the loop and two more, MOV; the pin is low from the next on: 0.54 us.
    CHECK(cut - low >= 66 && cut - low <= 70);
  }
}
