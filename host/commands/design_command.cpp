// strobe design: before the shot, from the uncertainty that is wanted to flashes, set-up and number of balls.
#include <fmt/format.h>

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/commands/command.hpp"
#include "host/commands/design_inputs.hpp"
#include "host/commands/shared_options.hpp"
#include "host/design/design_view.hpp"
#include "host/design/improvements.hpp"
#include "host/design/train_search.hpp"

namespace strobe::host {
namespace {

using reduction::Quantity;

/// At a terminal, every two seconds: how far the search is.
class SearchNotes {
 public:
  bool operator()(double share) {
    if (interrupted()) return false;
    const auto now = std::chrono::steady_clock::now();
    if (now - told_ >= std::chrono::seconds(2) && isatty(STDERR_FILENO)) {
      std::fprintf(stderr, "\rstrobe: searching for a train: %.0f %% ", 100.0 * share);
      told_ = now;
      shown_ = true;
    }
    return true;
  }
  ~SearchNotes() {
    if (shown_) std::fprintf(stderr, "\r%40s\r", "");
  }

 private:
  std::chrono::steady_clock::time_point told_ = std::chrono::steady_clock::now();
  bool shown_ = false;
};

/// The numbers that count where none are wanted by name: those that a series is fired for.
std::vector<Quantity> quantities_of(const DesignInputs& inputs) {
  std::vector<Quantity> quantities;
  for (const std::vector<Wanted>* list : {&inputs.wanted, &inputs.differences})
    for (const Wanted& wanted : *list)
      if (std::ranges::find(quantities, wanted.quantity) == quantities.end())
        quantities.push_back(wanted.quantity);
  if (!quantities.empty()) return quantities;
  return {Quantity::v_td_mps, Quantity::v_lo_mps, Quantity::omega_lo_radps, Quantity::e, Quantity::mu};
}

Result<void> search(const DesignInputs& inputs, const TrainWish& wish, DesignReport& report) {
  SearchNotes notes;
  auto found = best_train(inputs.design.ball, inputs.design.set_up, inputs.rig, inputs.design.plan, wish,
                          std::ref(notes));
  if (!found) return tl::unexpected(found.error());
  report.best = std::move(*found);
  return {};
}

Result<DesignReport> report_of(const DesignInputs& inputs) {
  DesignReport report;
  report.design = inputs.design;
  report.quantities = quantities_of(inputs);
  auto prediction = predict(inputs.design);
  if (!prediction) return tl::unexpected(prediction.error());
  report.prediction = std::move(*prediction);
  report.train_remark = inputs.train_remark;
  if (const ExpectedBall& ball = inputs.design.ball; ball.kind)
    report.remarks = balls::beyond_ranges(*ball.kind, ball.speed_mps.mean,
                                          -ball.speed_mps.mean * std::sin(ball.angle_rad.mean));
  if (inputs.search) {
    if (auto found = search(inputs, {report.quantities, inputs.most_images}, report); !found)
      return tl::unexpected(found.error());
  }
  report.needs = needs(report.prediction, inputs.wanted, inputs.differences, inputs.power);
  if (report.prediction.readable > 0) {
    auto better = improvements(inputs.design, inputs.rig, report.quantities,
                               report.best ? std::optional(report.best->plan) : std::nullopt);
    if (!better) return tl::unexpected(better.error());
    report.improvements = std::move(*better);
  }
  return report;
}

int run_design(const DesignOptions& options) {
  const auto inputs = design_inputs(options);
  if (!inputs) return bad_input("design: " + inputs.error().message);
  catch_signals();
  const auto report = report_of(*inputs);
  if (!report) return bad_input("design: " + report.error().message);
  if (!options.write_plan.empty()) {
    const PlanFile& plan = report->best ? report->best->plan : inputs->design.plan;
    if (auto written = config::write_file(options.write_plan, plan_to_toml(plan)); !written)
      return bad_input("design: --write-plan: " + written.error().message);
  }
  if (!options.figures.empty()) {
    if (auto drawn = write_design_figures(*report, options.figures); !drawn)
      return bad_input("design: --figures: " + drawn.error().message);
  }
  if (options.json)
    std::printf("%s\n", messages::json_text(design_json(*report)).c_str());
  else
    print(render_design(*report, kPlainWidth, options.all));
  return report->prediction.readable > 0 ? kDone : kFailed;
}

}  // namespace

void add_design_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<DesignOptions>();
  CLI::App* command =
      app.add_subcommand("design", "Before the shot: the uncertainty that a set-up will give");
  add_design_options(*command, *options);
  command->footer(
      "Example: strobe design --rig rig.toml --speed 17 --angle 23 --e 0.86 --e-sd 0.02 --want e:0.005\n"
      "         strobe design --rig rig.toml --like sessions/today --best-train --write-plan plan.toml\n"
      "Exit status: 0 done, 1 no shot of this design could be read, 2 bad usage or input.");
  command->callback([options, &exit_status] { exit_status = run_design(*options); });
}

}  // namespace strobe::host
