// strobe-bench board-plan: what `strobe calibrate --advise` promises against what calibrations then give.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/benchmarks/command.hpp"
#include "tests/studies/board/study.hpp"

namespace {

using namespace strobe::studies;

struct Options {
  BoardStudyPlan plan;
  bool json = false;
};

struct Kept {
  std::vector<double> ratios;  ///< predicted over stated
  double errors = 0.0;         ///< sum of squares, over the predicted

  void add(const Promise& promise) {
    ratios.push_back(promise.predicted / promise.stated);
    errors += std::pow(promise.error / promise.predicted, 2.0);
  }
  double within(double share) const {
    const auto n = std::ranges::count_if(
        ratios, [&](double r) { return r < 1.0 + share && r > 1.0 / (1.0 + share); });
    return static_cast<double>(n) / static_cast<double>(ratios.size());
  }
  double quantile(double share) {
    std::ranges::sort(ratios);
    return ratios[static_cast<std::size_t>(share * static_cast<double>(ratios.size() - 1))];
  }
  nlohmann::ordered_json json() {
    return {{"within_15_percent", within(0.15)},
            {"predicted_over_stated_p5", quantile(0.05)},
            {"predicted_over_stated_median", quantile(0.5)},
            {"predicted_over_stated_p95", quantile(0.95)},
            {"rms_error_over_predicted", std::sqrt(errors / static_cast<double>(ratios.size()))}};
  }
};

int report(const Options& options, const std::vector<BoardSetUp>& set_ups) {
  Kept advised, random;
  double log_before = 0.0, log_random = 0.0;
  int better = 0, failed = 0;
  for (const BoardSetUp& s : set_ups) {
    if (!s.failure.empty()) {
      ++failed;
      continue;
    }
    advised.add(s.advised);
    random.add(s.random);
    log_before += std::log(s.advised.stated / s.before);
    log_random += std::log(s.advised.stated / s.random.stated);
    better += s.advised.stated <= s.random.stated ? 1 : 0;
    if (!options.json)
      fmt::print("{} so far: {:.4f} %; advised: {:.4f} % predicted, {:.4f} % stated, {:.4f} % off; "
                 "random: {:.4f} %, {:.4f} %, {:.4f} %\n",
                 s.photographs, 100 * s.before, 100 * s.advised.predicted, 100 * s.advised.stated,
                 100 * s.advised.error, 100 * s.random.predicted, 100 * s.random.stated, 100 * s.random.error);
  }
  const auto n = static_cast<double>(advised.ratios.size());
  if (advised.ratios.empty()) {
    fmt::print(stderr, "strobe-bench: board-plan: no set-up could be measured: {}\n", set_ups.front().failure);
    return 1;
  }
  const nlohmann::ordered_json line{{"set_ups", advised.ratios.size()},
                                    {"failed", failed},
                                    {"advised", advised.json()},
                                    {"random", random.json()},
                                    {"advised_better_share", better / n},
                                    {"advised_over_before", std::exp(log_before / n)},
                                    {"advised_over_random", std::exp(log_random / n)}};
  fmt::print("{}\n", options.json ? line.dump() : line.dump(2));
  return 0;
}

int board_plan(const Options& options) {
  std::vector<BoardSetUp> set_ups;
  {
    std::atomic<int> done = 0;
    const std::jthread progress([&](const std::stop_token& stop) {
      for (int tick = 0; !stop.stop_requested(); ++tick) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        if (tick % 20 == 19) fmt::print(stderr, "\r{} of {} set-ups ", done.load(), options.plan.set_ups);
      }
      fmt::print(stderr, "\r{:40}\r", "");
    });
    set_ups = run(options.plan, done);
  }
  return report(options, set_ups);
}

}  // namespace

namespace strobe::studies {

void add_board_plan_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "board-plan",
      "what `strobe calibrate --advise` promises of the board's next photograph, against calibrations with that "
      "photograph, rendered; and against a placement drawn at random.\nExample: strobe-bench board-plan "
      "--set-ups 20");
  command->add_option("--set-ups", options->plan.set_ups, "cameras, lenses and boards, drawn")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--seed", options->plan.seed, "repeats a run, with any number of threads")
      ->capture_default_str();
  command->add_option("--threads", options->plan.threads, "run in parallel")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one object");
  command->callback([options, &exit_status] { exit_status = board_plan(*options); });
}

}  // namespace strobe::studies
