// strobe thesis: recomputes every table of the thesis beside the printed values, and draws its figures.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/command_line/command_line.hpp"
#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/commands/command.hpp"
#include "host/commands/terminal.hpp"
#include "host/figures/svg.hpp"
#include "host/thesis/figures.hpp"
#include "host/thesis/table.hpp"
#include "host/thesis/tables.hpp"

namespace strobe::host {

namespace {

namespace fs = std::filesystem;

struct ThesisOptions {
  std::string table;
  std::string set;
  std::string figures;
  bool all_sets = false;
  bool as_printed = false;
  std::string method{name(impact::ContactMethod::collocation)};
  bool json = false;
};

std::string ids() {
  std::string text;
  for (const thesis::TableEntry& entry : thesis::all_tables()) text += (text.empty() ? "" : ", ") + entry.id;
  return text;
}

std::string not_empty(const std::string& text) { return text.empty() ? "must not be empty" : ""; }

std::string contents() {
  std::string text;
  for (const thesis::TableEntry& entry : thesis::all_tables())
    text += "  " + entry.id + std::string(entry.id.size() < 13 ? 13 - entry.id.size() : 1, ' ') +
            entry.title + "\n";
  return text;
}

/// Tables without a row of the selected set are left out.
int print_tables(const thesis::ThesisInputs& inputs, const ThesisOptions& options) {
  bool first = true;
  for (const thesis::TableEntry& entry : thesis::all_tables()) {
    if (!options.table.empty() && entry.id != options.table) continue;
    const thesis::Table table = entry.make(inputs);
    if (table.rows.empty() && !options.set.empty()) continue;
    if (options.json) {
      std::printf("%s\n", thesis::json(table).c_str());
    } else {
      std::printf("%s%s", first ? "" : "\n", thesis::text(table).c_str());
    }
    first = false;
  }
  return first ? bad_input("thesis: table " + options.table + " has nothing of set " + options.set) : kDone;
}

/// What goes into one folder.
struct Sheet {
  fs::path folder;
  std::vector<std::string> sets;
};

std::vector<Sheet> sheets(const thesis::ThesisInputs& inputs, const ThesisOptions& options) {
  const fs::path folder(options.figures);
  if (!options.set.empty()) return {{folder / options.set, {options.set}}};
  std::vector<Sheet> out{{folder, {std::begin(thesis::kMainSets), std::end(thesis::kMainSets)}}};
  if (!options.all_sets) return out;
  for (const thesis::Condition* c : inputs.conditions()) out.push_back({folder / c->name(), {c->name()}});
  return out;
}

void show_progress(std::size_t done, std::size_t of, const fs::path& file) {
  const bool terminal = isatty(STDERR_FILENO) != 0;
  std::fprintf(stderr, "%sfigure %zu of %zu: %s%s", terminal ? "\r\033[K" : "", done, of, file.c_str(),
               terminal && done < of ? "" : "\n");
}

void print_figure(const figures::Figure& figure, const fs::path& base, bool json) {
  if (!json) return;
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const char* kind : {".svg", ".csv"}) files.push_back(base.string() + kind);
  const nlohmann::ordered_json out{{"figure", figure.number}, {"title", figure.title}, {"files", files}};
  std::printf("%s\n", messages::json_text(out).c_str());
}

/// A folder that cannot be made or written is bad input; found out before anything is drawn.
Result<void> check_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": cannot be made: " + error.message());
  if (access(folder.c_str(), W_OK | X_OK) != 0) return fail(folder.string() + ": cannot be written");
  return {};
}

int draw_figures(const thesis::ThesisInputs& inputs, const ThesisOptions& options) {
  if (const auto usable = check_folder(options.figures); !usable) return bad_input(usable.error().message);
  catch_signals();
  const std::vector<Sheet> all = sheets(inputs, options);
  const std::size_t of = all.size() * (thesis::kLastFigure - thesis::kFirstFigure + 1);
  std::size_t done = 0;
  for (const Sheet& sheet : all) {
    const auto all_figures = thesis::make_figures(inputs, sheet.sets);
    if (!all_figures) return failed("thesis: " + all_figures.error().message);
    for (const figures::Figure& figure : *all_figures) {
      if (interrupted()) return failed("thesis: interrupted; the figures drawn so far are whole");
      const std::string stem = fmt::format("figure_{:02}", figure.number);
      const fs::path base = sheet.folder / stem;
      show_progress(++done, of, base);
      if (const auto drawn = figures::write_figure(figure, sheet.folder, stem); !drawn)
        return failed("thesis: " + drawn.error().message);
      print_figure(figure, base, options.json);
    }
  }
  if (!options.json) std::printf("%zu figures in %s\n", done, options.figures.c_str());
  return kDone;
}

impact::ContactMethod method_of(const ThesisOptions& options) {
  const auto integrator = impact::ContactMethod::dormand_prince;
  return options.method == name(integrator) ? integrator : impact::ContactMethod::collocation;
}

int run_thesis(const ThesisOptions& options) {
  if (!options.table.empty() && !thesis::find_table(options.table))
    return bad_input("thesis: no table " + options.table + "; there are " + ids());
  if (options.all_sets && options.figures.empty())
    return bad_input("thesis: --all-sets is for --figures; tables show all sets anyway");
  const auto share = config::share_folder();
  if (!share) return bad_input(share.error().message);
  const auto version = options.as_printed ? thesis::Version::as_printed : thesis::Version::corrected;
  const auto inputs =
      thesis::load_inputs(*share / "thesis", version, options.set, {.method = method_of(options)});
  if (!inputs) return bad_input("thesis: " + inputs.error().message);
  return options.figures.empty() ? print_tables(*inputs, options) : draw_figures(*inputs, options);
}

}  // namespace

void add_thesis_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ThesisOptions>();
  CLI::App* command =
      app.add_subcommand("thesis", "The thesis's tables beside the printed values; its figures");
  CLI::Option* table =
      command->add_option("--table", options->table, "Only this table (--help-all lists them)");
  CLI::Option* set =
      command->add_option("--set", options->set, "Only this set, zero_17 to back_68; figures go to DIR/SET");
  CLI::Option* figures = command->add_option(
      "--figures", options->figures,
      "Draw Figures 4 to 17 into DIR instead, each as .svg with its data (.csv): the three spins at "
      "23 degrees");
  CLI::Option* all = command->add_flag("--all-sets", options->all_sets,
                                       "With --figures: besides, each of the 21 sets by itself, in DIR/SET");
  figures->excludes(table);
  all->excludes(set);
  figures->type_name("DIR");
  for (CLI::Option* option : {table, set, figures}) option->check(not_empty);
  command->add_flag("--as-printed", options->as_printed, "The thesis's data without its corrections");
  command
      ->add_option("--method", options->method,
                   "How the contact mechanics is computed: collocation, or dormand_prince, the reference")
      ->check(CLI::IsMember({"collocation", "dormand_prince"}));
  command->add_flag("--json", options->json, "One JSON object for each table, or figure, on stdout");
  command_line::for_experts(*command, {"--method"});
  command->footer(
      "Examples: strobe thesis --table 8\n"
      "          strobe thesis --set zero_23 --json\n"
      "          strobe thesis --figures figures --all-sets\n"
      "\f"
      "Tables 2 to 17 are the thesis's, the others go beyond it:\n" +
      contents() +
      "Figures are numbered in the thesis's order of topics: 4-9 differentiation (distance, drop, "
      "rotation, velocities, spin and slip, forces), 10-14 integration (the same), 15 and 16 both "
      "approaches, 17 touchdown to lift-off.");
  command->callback([options, &exit_status] { exit_status = run_thesis(*options); });
}

}  // namespace strobe::host
