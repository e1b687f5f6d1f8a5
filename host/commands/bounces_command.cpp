// strobe bounces: bounces that others have published, as the impact models predict them.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "common/config/files.hpp"
#include "host/bounces/report.hpp"
#include "host/commands/command.hpp"
#include "host/figures/svg.hpp"

namespace strobe::host {

namespace {

struct BouncesOptions {
  std::string set;
  std::string data;
  std::string figure;
  bool json = false;
  bool summary = false;
};

constexpr const char* kLegend =
    "Predicted before anything is fitted, with each bounce's own e. z: predicted less measured over the sd "
    "of\n"
    "that difference. *: this bounce's own impulse ratio is mu, and vx no prediction.\n";

Result<published::Bounces> load(const BouncesOptions& options) {
  if (!options.data.empty()) return published::load_bounces(options.data);
  const auto share = config::share_folder();
  if (!share) return tl::unexpected(share.error());
  return published::load_bounces(*share / "bounces");
}

std::string names_of(const published::Bounces& all) {
  std::string names;
  for (const published::Set& set : all.sets) names += (names.empty() ? "" : ", ") + set.name;
  return names;
}

int draw(const std::vector<bounces::Row>& rows, const std::string& folder) {
  const auto drawn = figures::write_figure(bounces::spin_figure(rows), folder, "figure_01");
  return drawn ? kDone : failed("bounces: " + drawn.error().message);
}

int run_bounces(const BouncesOptions& options) {
  const auto all = load(options);
  if (!all) return bad_input("bounces: " + all.error().message);
  if (!options.set.empty() && all->set(options.set) == nullptr)
    return bad_input("bounces: no set " + options.set + "; there are " + names_of(*all));
  if (options.summary)
    std::fputs(bounces::summary_head().c_str(), stdout);
  else if (!options.json)
    std::fputs(kLegend, stdout);
  std::vector<bounces::Row> drawn;
  for (const published::Set& set : all->sets) {
    if (!options.set.empty() && set.name != options.set) continue;
    const auto rows = bounces::rows_of(*all, set);
    if (!rows) return bad_input("bounces: " + rows.error().message);
    if (options.summary)
      std::fputs(bounces::summary(set, *rows).c_str(), stdout);
    else if (!options.json)
      std::printf("\n%s", bounces::text(set, *rows).c_str());
    for (const bounces::Row& row : *rows)
      if (options.json) std::printf("%s\n", bounces::json(set, row).c_str());
    drawn.insert(drawn.end(), rows->begin(), rows->end());
  }
  return options.figure.empty() ? kDone : draw(drawn, options.figure);
}

}  // namespace

void add_bounces_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<BouncesOptions>();
  CLI::App* command =
      app.add_subcommand("bounces", "Predict the bounces that others have published, and compare.");
  command->add_option("--set", options->set, "Only this set, e.g. cross_2002_table_2");
  command->add_option("--data", options->data, "Folder of data sets (default: the shipped ones)");
  command->add_option("--figure", options->figure,
                      "Draw predicted against measured spin into this folder: figure_01.svg and .csv");
  CLI::Option* json = command->add_flag("--json", options->json, "One JSON object a bounce");
  command
      ->add_flag("--summary", options->summary,
                 "A line for each set and model: coverage, residuals, validity")
      ->excludes(json);
  command->footer(
      "Example: strobe bounces --set cross_2002_table_2\n"
      "Exit status: 1 if the figure cannot be drawn, 2 for bad usage or data.");
  command->callback([options, &exit_status] { exit_status = run_bounces(*options); });
}

}  // namespace strobe::host
