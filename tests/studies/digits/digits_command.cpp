// strobe-bench digits: how many digits every closed form of the analysis keeps, beside the textbook's way of
// writing it.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/benchmarks/command.hpp"
#include "tests/common/numerics/forms/digits.hpp"

namespace strobe::studies {

namespace {

using numerics::Measured;

struct Options {
  std::size_t samples = 4000;
  std::uint64_t seed = 1;
  std::string only;
  bool json = false;
};

void print_json(const Measured& row) {
  const auto number = [](double x) {
    return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json("infinite");
  };
  const auto& w = row.worst;
  nlohmann::json line{{"form", row.form},
                      {"output", row.output},
                      {"samples", w.samples},
                      {"worst_error", number(w.error)},
                      {"worst_ulps", number(w.ulps)},
                      {"argument", w.argument},
                      {"natural_scale", row.scale},
                      {"tolerance", row.tolerance}};
  if (w.textbook_error) {
    line["textbook_error"] = number(*w.textbook_error);
    line["textbook_argument"] = w.textbook_argument;
  }
  if (!row.rewritten.empty()) line["rewritten"] = row.rewritten;
  std::printf("%s\n", line.dump().c_str());
}

std::string shortened(double x) {
  if (!std::isfinite(x)) return "lost";
  char text[24];
  std::snprintf(text, sizeof text, "%.1e", x);
  return text;
}

void print_table(const std::vector<Measured>& rows) {
  std::string form;
  for (const Measured& row : rows) {
    if (row.form != form) {
      form = row.form;
      std::printf("\n%s\n  natural scale: %s\n", form.c_str(), row.scale.c_str());
      if (!row.rewritten.empty()) std::printf("  rewritten: %s\n", row.rewritten.c_str());
      std::printf("  %-20s %8s %9s %7s %10s\n", "output", "samples", "error", "ulps", "textbook");
    }
    const auto& w = row.worst;
    std::printf("  %-20s %8zu %9s %7.1f %10s%s\n", row.output.c_str(), w.samples, shortened(w.error).c_str(),
                w.ulps, w.textbook_error ? shortened(*w.textbook_error).c_str() : "same",
                w.error > row.tolerance ? "  OVER 1e-13" : "");
    std::printf("    at %s\n", w.argument.c_str());
    if (w.textbook_error && *w.textbook_error > row.tolerance)
      std::printf("    textbook at %s\n", w.textbook_argument.c_str());
  }
}

/// Forms whose textbook writing loses more than the tolerance, worst first.
void print_failed(const std::vector<Measured>& rows) {
  std::printf("\nTextbook forms beyond 1e-13, and how they were rewritten\n");
  for (const Measured& row : rows) {
    const auto& w = row.worst;
    if (!w.textbook_error || !(*w.textbook_error > row.tolerance)) continue;
    std::printf("  %-52s %9s -> %-9s %s\n", (row.form + ": " + row.output).c_str(),
                shortened(*w.textbook_error).c_str(), shortened(w.error).c_str(), row.rewritten.c_str());
  }
}

int run(const Options& options) {
  const auto forms = numerics::all_forms();
  std::vector<Measured> rows;
  std::size_t done = 0;
  for (const numerics::Form& form : forms) {
    if (isatty(STDERR_FILENO) != 0)
      std::fprintf(stderr, "\r%zu of %zu forms, %-40s", ++done, forms.size(), form.name.c_str());
    if (form.name.find(options.only) == std::string::npos) continue;
    for (Measured& row : numerics::measure(form, options.samples, options.seed))
      rows.push_back(std::move(row));
  }
  if (isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "\r%-60s\r", "");
  if (rows.empty()) {
    std::fprintf(stderr, "strobe-bench: --form %s: no form has that in its name\n", options.only.c_str());
    return 2;
  }
  bool all_kept = true;
  for (const Measured& row : rows) all_kept = all_kept && row.worst.error <= row.tolerance;
  if (options.json) {
    for (const Measured& row : rows) print_json(row);
  } else {
    std::printf(
        "Largest errors against 50 digits, %zu samples a form, seed %llu. In units of the larger of the "
        "value "
        "and its natural scale.\n",
        options.samples, static_cast<unsigned long long>(options.seed));
    print_table(rows);
    print_failed(rows);
    std::printf("\n%s\n", all_kept ? "Every form keeps 1e-13." : "A FORM LOSES MORE THAN 1e-13.");
  }
  return all_kept ? 0 : 1;
}

}  // namespace

void add_digits_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("digits",
                                         "digits that every closed form keeps, against 50-digit arithmetic, "
                                         "beside the textbook's form\nExample: "
                                         "strobe-bench digits --samples 2000 --form pulse");
  command
      ->add_option("--samples", options->samples, "samples of each form, half by structure, half at random")
      ->check(CLI::Range(std::size_t{2}, std::size_t{10'000'000}))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "seed of the random samples")->capture_default_str();
  command->add_option("--form", options->only, "only forms with this in their name");
  command->add_flag("--json", options->json, "one JSON object per output, nothing else on stdout");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::studies
