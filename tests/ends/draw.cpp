#include <fmt/format.h>

#include <array>
#include <csignal>
#include <cstring>
#include <random>

#include "tests/ends/failing_calls.hpp"
#include "tests/ends/trial.hpp"

namespace strobe::ends {
namespace {

/// In the order of FaultKind: how often of 100, and words.
struct FaultDraw {
  int weight;
  const char* words;
};
constexpr std::array<FaultDraw, 11> kFaults{{{40, ""},
                                             {6, "stopped"},
                                             {8, "a thread stands still"},
                                             {8, "a thread ends"},
                                             {12, "a descriptor is closed"},
                                             {14, ""},
                                             {2, "no more descriptors"},
                                             {3, "no file may grow"},
                                             {2, "no more memory"},
                                             {2, "no real-time CPU"},
                                             {3, "the chip is removed"}}};
constexpr std::array<const char*, 6> kMoments{"at rest",    "armed", "trigger on",
                                              "shutter on", "flash", "shutter off"};
constexpr std::array<const char*, 3> kVictims{"worker", "guardian", "both"};

int between(std::mt19937_64& random, int least, int most) {
  return std::uniform_int_distribution<int>(least, most)(random);
}

std::string signal_words(int number) {
  const char* const abbreviation = sigabbrev_np(number);
  return abbreviation == nullptr ? fmt::format("signal {}", number) : fmt::format("SIG{}", abbreviation);
}

const char* victim_of(const Trial& trial) {
  return trial.fault == FaultKind::removed_chip ? "chip" : kVictims[static_cast<std::size_t>(trial.victim)];
}

/// Where one process must be left to see to the outputs.
bool of_one_process(const Trial& trial) {
  return trial.fault == FaultKind::stop || trial.fault == FaultKind::held_thread ||
         (trial.fault == FaultKind::signal && trial.argument == SIGSTOP);
}

}  // namespace

Trial drawn_trial(std::uint64_t seed, int number) {
  std::seed_seq words{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                      static_cast<std::uint32_t>(number)};
  std::mt19937_64 random(words);
  std::array<int, kFaults.size()> weights{};
  for (std::size_t k = 0; k < kFaults.size(); ++k) weights[k] = kFaults[k].weight;
  Trial trial;
  trial.fault =
      static_cast<FaultKind>(std::discrete_distribution<int>(weights.begin(), weights.end())(random));
  trial.argument = trial.fault == FaultKind::signal ? between(random, 1, 64) : between(random, 0, 999);
  trial.victim = static_cast<Victim>(between(random, 0, 2));
  if (of_one_process(trial) && trial.victim == Victim::both) trial.victim = Victim::worker;
  // Most of a shot is its train.
  trial.moment = static_cast<Moment>(std::discrete_distribution<int>({1, 1, 2, 2, 6, 1})(random));
  trial.nth = trial.moment == Moment::flash ? between(random, 1, 40) : 1;
  trial.delay_us = between(random, 0, 6000);
  // A chip that is removed and keeps its lines is beyond every program's reach.
  trial.keeps = between(random, 0, 3) != 0 && trial.fault != FaultKind::removed_chip;
  return trial;
}

const char* name(Moment moment) { return kMoments[static_cast<std::size_t>(moment)]; }

std::string describe_family(const Trial& trial) {
  if (trial.fault == FaultKind::signal) return fmt::format("{}, a signal", victim_of(trial));
  if (trial.fault == FaultKind::failing_call)
    return fmt::format("{}, {} fails", victim_of(trial), failing_call(trial.argument).name);
  return describe_fault(trial);
}

std::string describe_fault(const Trial& trial) {
  std::string fault = kFaults[static_cast<std::size_t>(trial.fault)].words;
  if (trial.fault == FaultKind::signal) fault = signal_words(trial.argument);
  if (trial.fault == FaultKind::failing_call) fault = failing_call(trial.argument).words() + " fails";
  return fmt::format("{}, {}", victim_of(trial), fault);
}

std::string describe(const Trial& trial) {
  std::string moment = name(trial.moment);
  if (trial.moment == Moment::flash) moment += fmt::format(" {}", trial.nth);
  return fmt::format("{}, {} + {} us, chip {}", describe_fault(trial), moment, trial.delay_us,
                     trial.keeps ? "keeps" : "lets go");
}

}  // namespace strobe::ends
