// strobe report: what was measured in one or several sessions, as a laboratory would sign it.
#include <unistd.h>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "common/command_line/command_line.hpp"
#include "common/config/files.hpp"
#include "host/archive/read_session.hpp"
#include "host/commands/command.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/protocol/session_protocol.hpp"
#include "host/report/pdf.hpp"
#include "host/report/report.hpp"

namespace strobe::host {

namespace {

namespace fs = std::filesystem;
using report::ReportInput;

struct ReportOptions {
  std::vector<std::string> folders;
  std::string out;
  SessionOptions session;
  std::vector<std::string> limits, over;
  std::string rule = "guarded";
  Statements statements;
  bool pdf = false;
  bool all = false;
  bool thesis = false;
  bool json = false;
};

/// Work of more than two seconds is told of, from then on.
class ReportProgress {
 public:
  void tell(std::size_t done, std::size_t of, const std::string& at) {
    const auto now = std::chrono::steady_clock::now();
    if (now - begun_ < std::chrono::seconds(2) || now - shown_ < std::chrono::milliseconds(500)) return;
    shown_ = now;
    const bool terminal = isatty(STDERR_FILENO) != 0;
    std::fprintf(stderr, "%sreport: %s, %zu of %zu%s", terminal ? "\r\033[K" : "", at.c_str(), done, of,
                 terminal ? "" : "\n");
    line_open_ = terminal;
  }
  ~ReportProgress() {
    if (line_open_) std::fputs("\r\033[K", stderr);
  }
  ReportProgress() = default;
  ReportProgress(const ReportProgress&) = delete;
  ReportProgress& operator=(const ReportProgress&) = delete;

 private:
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point shown_{};
  bool line_open_ = false;
};

std::string option_name(const StatementKey& key) {
  std::string name = "--" + std::string(key.id);
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

/// What the options state, as far as it can be understood.
Result<ReportInput> stated_input(const ReportOptions& options) {
  ReportInput input;
  input.version = STROBE_VERSION;
  input.all = options.all;
  for (const StatementKey& key : kStatementKeys) {
    const auto given = options.statements.find(std::string(key.id));
    if (given == options.statements.end() || given->second.empty()) continue;
    if (const auto problem = statement_problem(key, given->second))
      return fail("report: " + option_name(key) + " " + *problem);
    input.statements[given->first] = given->second;
  }
  for (const std::string& text : options.limits) {
    const auto limit = report::parse_limit(text);
    if (!limit) return fail("report: " + limit.error().message);
    input.limits.push_back(*limit);
  }
  input.over = options.over;
  if (options.rule == "simple") input.rule = report::DecisionRule::simple;
  return input;
}

/// Beside a PDF that --out names.
fs::path html_path(const ReportOptions& options) {
  if (options.out.empty()) return fs::path(options.folders.front()) / "report.html";
  fs::path out = options.out;
  if (out.extension() == ".pdf") out.replace_extension(".html");
  return out;
}

int write_report(const report::Report& made, const ReportOptions& options, const fs::path& printer) {
  const fs::path html = html_path(options);
  if (const auto done = config::write_file(html, report::render_html(made)); !done)
    return failed("report: " + done.error().message);
  if (!options.json) std::printf("report %s: %s\n", made.id.c_str(), html.c_str());
  if (!options.pdf) return kDone;
  fs::path pdf = html;
  pdf.replace_extension(".pdf");
  if (const auto done = report::print_pdf(printer, html, pdf, made.issued); !done)
    return failed("report: " + done.error().message);
  if (!options.json) std::printf("report %s: %s\n", made.id.c_str(), pdf.c_str());
  return kDone;
}

int run_report(const ReportOptions& options) {
  auto input = stated_input(options);
  if (!input) return bad_input(input.error().message);
  if (!options.pdf && fs::path(options.out).extension() == ".pdf")
    return bad_input("report: --out " + options.out + ": a PDF is written with --pdf");
  fs::path printer;
  if (options.pdf) {
    const auto found = report::find_pdf_printer();
    if (!found) return failed("report: " + found.error().message);
    printer = *found;
  }
  for (const std::string& folder : options.folders) {
    auto session =
        read_session(folder, {options.session.rig_path, options.session.key_file, reading_notes(folder)});
    if (!session) return bad_input(session.error().message);
    input->sessions.push_back(*std::move(session));
  }
  auto protocol = protocol::protocol_of_session(input->sessions.front().folder);
  if (!protocol) return bad_input(protocol.error().message);
  input->protocol = std::move(*protocol);
  const auto thesis = options.thesis ? report::shipped_thesis() : std::nullopt;
  if (options.thesis && !thesis) return failed("report: --thesis: its tables are not installed");
  input->thesis = thesis ? &*thesis : nullptr;
  ReportProgress progress;
  input->progress = [&](std::size_t done, std::size_t of, const std::string& at) {
    progress.tell(done, of, at);
  };
  const report::Report made = report::build_report(*input);
  if (options.json) std::printf("%s\n", report::report_json(made).c_str());
  if (options.json && options.out.empty() && !options.pdf) return kDone;
  return write_report(made, options, printer);
}

/// What few state on the command line: the rig file is the place for it.
std::vector<std::string> seldom_stated() {
  std::vector<std::string> names;
  for (const StatementKey& key : kStatementKeys) {
    const bool often =
        key.id == "title" || key.id == "laboratory" || key.id == "customer" || key.id == "item";
    if (!often) names.push_back(option_name(key));
  }
  return names;
}

void add_statements(CLI::App& command, ReportOptions& options) {
  for (const StatementKey& key : kStatementKeys)
    command
        .add_option(option_name(key), options.statements[std::string(key.id)],
                    fmt::format("{}, as \"{}\"", key.label, key.example))
        ->type_name("TEXT");
}

}  // namespace

void add_report_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command = app.add_subcommand("report", "A session's report that a laboratory could sign");
  command->add_option("SESSION", options->folders, "Folders that `strobe fire` wrote")->required();
  command->add_option("--out", options->out, "File to write (default: report.html in the first folder)")
      ->type_name("FILE.html");
  command->add_flag("--pdf", options->pdf, "FILE.pdf besides FILE.html, if weasyprint is installed");
  command
      ->add_option("--limit", options->limits,
                   "State conformity of each condition's mean; as e=0.80..0.86 or e=..0.86; may be repeated")
      ->type_name("QUANTITY=LOW..HIGH")
      ->allow_extra_args(false);
  command
      ->add_option("--decision-rule", options->rule,
                   "guarded: guard bands as wide as the expanded uncertainty; simple: simple acceptance")
      ->check(CLI::IsMember({"guarded", "simple"}))
      ->capture_default_str();
  add_over_option(*command, options->over);
  command->add_flag("--all", options->all, "All quantities, and every condition's full budgets and figures");
  command->add_flag(
      "--thesis", options->thesis,
      "The reference thesis's means beside one's own, and its figures of the images in contact");
  command->add_flag("--json", options->json,
                    "The whole report as one JSON object on standard output; a file only with --out");
  add_session_options(*command, options->session);
  add_statements(*command, *options);
  std::vector<std::string> seldom = seldom_stated();
  seldom.insert(seldom.end(), {"--rig", "--key-file"});
  command_line::for_experts(*command, seldom);
  command->footer(
      "What is not stated is printed as \"not stated\" and listed at the report's end.\n"
      "Example: strobe report sessions/today --laboratory \"Sports Surfaces Laboratory\" --limit "
      "e=0.80..0.90 --pdf");
  command->callback([options, &exit_status] { exit_status = run_report(*options); });
}

}  // namespace strobe::host
