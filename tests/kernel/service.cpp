#include "tests/kernel/service.hpp"

#include <cstdio>

namespace strobe::kernel {

namespace {

constexpr int kMidTrain = 5;
constexpr int kMaxAttempts = 5;
constexpr const char* kLongPlan =
    "train = \"free\"\nperiod_us = 130000\nshutter_open_ms = 9750\nimpact_at_ms = 1300\n";

}  // namespace

std::string Service::word(const std::string& line) {
  std::string text = shell(line);
  text.erase(text.find_last_not_of(" \r\n") + 1);
  return text;
}

bool Service::becomes(const std::string& state) {
  return testing::wait_until([&] { return property("ActiveState") == state; }, kTimeout);
}

std::vector<int> Service::flashes_of_each_shot() const {
  std::vector<int> counts;
  const auto events = bench_.events();
  for (std::size_t i = before_; i < events.size(); ++i) {
    if (events[i].level != 1) continue;
    if (events[i].pin == Pin::shutter) counts.push_back(0);
    if (events[i].pin == Pin::strobe_a && !counts.empty()) ++counts.back();
  }
  return counts;
}

testing::CompletedProcess Service::fire_a_shot() {
  testing::CompletedProcess fired;
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    fired = testing::run_process(bench_.strobe({"fire", "--shots", "1", "--retries", "0", "--json",
                                                "--session", (bench_.folder() / "session").string()}),
                                 kTimeout);
    const auto counts = flashes_of_each_shot();
    if (!counts.empty() && counts.back() == kFlashes) break;
  }
  return fired;
}

std::unique_ptr<testing::Process> Service::fire_and_wait_for_the_train() {
  const std::filesystem::path plan = bench_.folder() / "plan.toml";
  testing::write_text(plan, kLongPlan);
  const auto under_way = [this] {
    const auto counts = flashes_of_each_shot();
    return !counts.empty() && counts.back() >= kMidTrain;
  };
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    auto firing = std::make_unique<testing::Process>(
        bench_.strobe({"fire", "--shots", "1", "--retries", "0", "--json", "--session",
                       (bench_.folder() / "long").string(), "--plan", plan.string()}),
        bench_.folder());
    testing::wait_until([&] { return under_way() || !firing->running(); }, kTimeout);
    if (firing->running() && under_way()) return firing;
    std::printf("%s", firing->err().c_str());
  }
  return nullptr;
}

}  // namespace strobe::kernel
