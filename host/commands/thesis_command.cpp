// strobe thesis: every table of the thesis computed anew beside the printed values, and its figures.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "host/commands/command.hpp"
#include "host/share.hpp"
#include "host/thesis/render.hpp"
#include "host/thesis/tables.hpp"

namespace strobe::host {

namespace {

struct ThesisOptions {
  std::string table;
  std::string set;
  bool as_printed = false;
  bool json = false;
};

std::string ids() {
  std::string text;
  for (const report::TableEntry& entry : report::catalogue()) text += (text.empty() ? "" : ", ") + entry.id;
  return text;
}

void print(const report::Table& table, bool json, bool first) {
  if (json) {
    std::printf("%s\n", report::json(table).c_str());
    return;
  }
  std::printf("%s%s", first ? "" : "\n", report::text(table).c_str());
}

int run_thesis(const ThesisOptions& options) {
  if (!options.table.empty() && !report::find_table(options.table))
    return bad_input("thesis: no table " + options.table + "; there are " + ids());
  const auto share = share_folder();
  if (!share) return bad_input(share.error().message);
  const auto version = options.as_printed ? thesis::Version::as_printed : thesis::Version::corrected;
  const auto material = report::load_material(*share / "thesis", version, options.set);
  if (!material) return bad_input("thesis: " + material.error().message);
  bool first = true;
  for (const report::TableEntry& entry : report::catalogue()) {
    if (!options.table.empty() && entry.id != options.table) continue;
    const report::Table table = entry.make(*material);
    if (table.rows.empty()) continue;
    print(table, options.json, first);
    first = false;
  }
  return kDone;
}

}  // namespace

void add_thesis_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ThesisOptions>();
  CLI::App* command = app.add_subcommand(
      "thesis", "Compute every table of the thesis anew beside the printed values, and draw its figures.");
  command->add_option("--table", options->table, "Only this table: " + ids());
  command->add_option("--set", options->set, "Only this set, zero_17 to back_68");
  command->add_flag("--as-printed", options->as_printed, "The thesis's data without its corrections");
  command->add_flag("--json", options->json, "One JSON object for each table on stdout");
  command->footer("Examples: strobe thesis --table 8\n          strobe thesis --set zero_23 --json");
  command->callback([options, &exit_status] { exit_status = run_thesis(*options); });
}

}  // namespace strobe::host
