// strobe compare: what several laboratories report, side by side.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "common/config/files.hpp"
#include "host/commands/command.hpp"
#include "host/commands/terminal.hpp"
#include "host/figures/svg.hpp"
#include "host/interlaboratory/comparison.hpp"

namespace strobe::host {

namespace {

using namespace interlaboratory;

struct CompareOptions {
  std::vector<std::string> reports, quantities, assessment_sds;
  std::string reference, figure;
  bool json = false;
};

/// NAME=FILE, or a file alone.
Result<LaboratoryReport> read_named(const std::string& text) {
  const std::size_t sign = text.find('=');
  const std::string file = sign == std::string::npos ? text : text.substr(sign + 1);
  const auto content = config::read_file(file);
  if (!content) return tl::unexpected(content.error());
  return read_report(*content, file, sign == std::string::npos ? "" : text.substr(0, sign));
}

Result<ComparisonTerms> terms_of(const CompareOptions& options) {
  ComparisonTerms terms{options.reference, {}, options.quantities};
  for (const std::string& text : options.assessment_sds) {
    const std::size_t colon = text.rfind(':');
    char* end = nullptr;
    const double sd = colon == std::string::npos ? 0.0 : std::strtod(text.c_str() + colon + 1, &end);
    if (!(sd > 0.0) || !std::isfinite(sd) || *end != '\0')
      return fail("--assessment-sd " + text + ": as e:0.005, the number above 0");
    terms.assessment_sd[text.substr(0, colon)] = sd;
  }
  return terms;
}

int run_compare(const CompareOptions& options) {
  std::vector<LaboratoryReport> reports;
  for (const std::string& text : options.reports) {
    auto report = read_named(text);
    if (!report) return bad_input("compare: " + report.error().message);
    reports.push_back(*std::move(report));
  }
  const auto terms = terms_of(options);
  if (!terms) return bad_input("compare: " + terms.error().message);
  const auto comparison = compare(reports, *terms);
  if (!comparison) return bad_input("compare: " + comparison.error().message);
  for (const std::string& remark : comparison->remarks) std::fprintf(stderr, "strobe: %s\n", remark.c_str());
  if (options.json)
    for (const ComparedQuantity& each : comparison->quantities) print({comparison_json(each)});
  else
    print(comparison_text(*comparison));
  if (!options.figure.empty()) {
    const auto drawn = figures::write_figure(comparison_figure(*comparison), options.figure, "laboratories",
                                             comparison->laboratories);
    if (!drawn) return failed("compare: " + drawn.error().message);
  }
  return all_agree(*comparison) ? kDone : kFailed;
}

}  // namespace

void add_compare_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand("compare", "Laboratories' results: E_n numbers, z and zeta scores");
  command
      ->add_option("NAME=FILE", options->reports,
                   "two or more laboratories: what their `strobe series --json` or `protocol verdict --json` "
                   "printed, or a list of results")
      ->required();
  command->add_option("--reference", options->reference,
                      "laboratory that the others are held against (default: of two the first, of more "
                      "their robust mean)");
  command->add_option("--quantity", options->quantities, "only these, as e,mu (default: all that they share)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option("--assessment-sd", options->assessment_sds,
                   "what z scores are in, as e:0.005,mu:0.01 (default: the laboratories' robust sd)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--figure", options->figure,
                      "draw results beside the assigned value into this folder: laboratories.svg and .csv");
  command->add_flag("--json", options->json, "one JSON object a quantity");
  command->footer(
      "Example: strobe compare north=n.jsonl south=s.jsonl --reference north --quantity e,mu\n"
      "Exit status: 1 if a score is unsatisfactory: |E_n| > 1, or |z| or |zeta| >= 3.");
  command->callback([options, &exit_status] { exit_status = run_compare(*options); });
}

}  // namespace strobe::host
