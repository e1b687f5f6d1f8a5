// strobe-commission-study: rigs with one fault each, and sound ones, commissioned through the shipped programs: which step
// found the fault, by which number, and what was found on sound rigs. By hand, on an idle machine: in real time, one to two
// minutes a rig.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "tests/commission/wrong_rigs.hpp"
#include "tests/support/private_network.hpp"

using namespace strobe::commission_bench;

namespace {

struct Plan {
  int good = 20, balls = 9;
  std::uint64_t seed = 1;
  std::string only, keep;
  bool list = false, no_faults = false, whole = false;
};

std::string number(const nlohmann::json& step) {
  if (!step.contains("value") || step.at("value").is_null()) return "-";
  return fmt::format("{:.4g} {}", step.at("value").get<double>(), step.value("unit", ""));
}

/// The steps that should find it, and those without which no ball is thrown.
std::vector<std::string> enough_for(const WrongRig& rig) {
  std::vector<std::string> steps{"firmware", "key", "key_wire", "estop", "estop_wire"};
  steps.insert(steps.end(), rig.found_by.begin(), rig.found_by.end());
  return steps;
}

/// Whether it was found by a step that should.
bool report(const WrongRig& rig, const Outcome& outcome) {
  if (!outcome.trouble.empty()) {
    fmt::print("| {} | TROUBLE: {} | | | {:.0f} |\n", rig.name, outcome.trouble, outcome.seconds);
    return false;
  }
  const auto failures = outcome.failures();
  const std::string found = found_by(rig, outcome);
  if (found.empty()) {
    fmt::print("| {} | NOT FOUND | | failed: {} | {:.0f} |\n", rig.name, fmt::join(failures, ", "),
               outcome.seconds);
    return false;
  }
  const nlohmann::json& step = *outcome.step(found);
  fmt::print("| {} | {}: {} | {} | {} | {:.0f} |\n", rig.name, found, step.value("fault", ""), number(step),
             step.value("words", ""), outcome.seconds);
  return true;
}

bool report_good(std::uint64_t seed, const Outcome& outcome) {
  std::string figures;
  int passed = 0;
  for (const auto& step : outcome.steps) {
    passed += step.at("state") == "passed";
    if (step.at("state") != "passed")
      figures += fmt::format(" {}: {} ({});", step.at("step").get<std::string>(),
                             step.at("state").get<std::string>(), step.value("words", ""));
    else if (step.contains("value") && !step.at("value").is_null())
      figures += fmt::format(" {} {};", step.at("step").get<std::string>(), number(step));
  }
  const bool good = outcome.trouble.empty() && outcome.failures().empty() && passed > 10;
  fmt::print("| seed {} | {} | {} passed |{} {} | {:.0f} |\n", seed, good ? "nothing" : "INVENTED", passed,
             figures, outcome.trouble, outcome.seconds);
  return good;
}

void add_options(CLI::App& app, Plan& plan) {
  app.add_option("--good", plan.good, "sound rigs, of as many seeds (default 20)");
  app.add_option("--balls", plan.balls, "thrown at each (default 9)");
  app.add_option("--seed", plan.seed, "first seed");
  app.add_option("--only", plan.only, "faults whose name has this text");
  app.add_option("--keep", plan.keep, "keep the files of each rig below this folder");
  app.add_flag("--no-faults", plan.no_faults, "sound rigs alone");
  app.add_flag("--whole", plan.whole, "all steps of rigs with a fault, not only those that should find it");
  app.add_flag("--list", plan.list, "print the faults' names");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Commissions rigs with a fault each, and sound ones"};
  Plan plan;
  add_options(app, plan);
  CLI11_PARSE(app, argc, argv);
  if (plan.list) {
    for (const WrongRig& rig : wrong_rigs()) fmt::print("{}\n", rig.name);
    return 0;
  }
  const strobe::testing::IsolatedEnvironment isolated;
  int missed = 0, tried = 0, number_of_rig = 0;
  fmt::print("| fault | found by step: fault | number | words | s |\n|---|---|---|---|---|\n");
  for (WrongRig rig : wrong_rigs()) {
    ++number_of_rig;
    if (plan.no_faults || rig.name.find(plan.only) == std::string::npos) continue;
    rig.options.seed = plan.seed + static_cast<std::uint64_t>(number_of_rig);
    rig.options.balls = plan.balls;
    if (!plan.whole) rig.options.only = enough_for(rig);
    if (!plan.keep.empty()) rig.options.keep = plan.keep + "/" + std::to_string(number_of_rig);
    missed += !report(rig, commission(rig.options));
    ++tried;
    std::fflush(stdout);
  }
  for (int i = 0; i < plan.good; ++i) {
    BenchOptions options;
    options.seed = plan.seed + 1000 + static_cast<std::uint64_t>(i);
    options.balls = plan.balls;
    if (!plan.keep.empty()) options.keep = plan.keep + "/good-" + std::to_string(i + 1);
    missed += !report_good(options.seed, commission(options));
    std::fflush(stdout);
  }
  fmt::print("\n{} faults, {} sound rigs; {} wrong verdicts\n", tried, plan.good, missed);
  return missed == 0 ? 0 : 1;
}
