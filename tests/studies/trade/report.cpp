#include "tests/studies/trade/report.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace strobe::studies::trade {

namespace {

std::string cost(double us) {
  if (us < 10.0) return fmt::format("{:.3f}", us);
  return us < 1000.0 ? fmt::format("{:.1f}", us) : fmt::format("{:.0f}", us);
}

const char* name(Source source) {
  switch (source) {
    case Source::model:
      return "model";
    case Source::numerical:
      return "numerical";
    case Source::noise:
      return "noise";
  }
  return "";
}

std::string times(double factor) {
  if (factor < 9.95) return fmt::format("{:.1f} times", factor);
  return factor < 1e4 ? fmt::format("{:.0f} times", factor) : fmt::format("{:.0e} times", factor);
}

/// "2.4 times slower and as exact".
std::string how_much(const Dominated& by) {
  const std::string cost = by.slower < 1.05 ? "as fast" : times(by.slower) + " slower";
  const std::string error = by.worse < 1.05 ? "as exact" : times(by.worse) + " less exact";
  return cost + " and " + error;
}

std::string verdict(const Study& study, const std::optional<Dominated>& by) {
  if (!by) return "frontier";
  return fmt::format("dominated by {}: {}", label(study.rows[by->by]), how_much(*by));
}

/// A field of a file whose separator is the comma.
std::string field(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  return text;
}

}  // namespace

std::string table_text(const Study& study) {
  std::string text = fmt::format("== {}: {}\n   {}\n", study.name, study.title, study.what);
  if (study.reference > 0.0) text += fmt::format("   the reference's own error: {:.1e}\n", study.reference);
  text += fmt::format("   errors {}\n", study.unit);
  std::size_t width = 20;
  for (const Row& row : study.rows) width = std::max(width, label(row).size() + 1);
  text += fmt::format("{:<{}} {:>9} {:>9} {:>9} {:>9} {:>9}  {:<9} {}\n", "method", width, "us a call", "rms",
                      "worst", "rms, 21", "worst, 21", "error", "verdict");
  const auto verdicts = dominated(study);
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    const Row& row = study.rows[i];
    text += fmt::format("{:<{}} {:>9} {:>9.1e} {:>9.1e} {:>9.1e} {:>9.1e}  {:<9} {}{}\n", label(row), width,
                        cost(row.cost_us), row.practical.rms, row.practical.worst, row.thesis.rms,
                        row.thesis.worst, name(row.source), verdict(study, verdicts[i]),
                        row.remark.empty() ? "" : "; " + row.remark);
  }
  return text;
}

std::string engines_text(const Study& study) {
  const auto general = std::ranges::count(study.rows, true, &Row::general);
  if (general == 0) return {};
  std::string text;
  const auto list = [&](const std::string& without, const char* by) {
    const auto beyond = beyond_own(study, without);
    text += fmt::format("{} of {} rows of engines are neither faster nor more exact than {}\n",
                        general - static_cast<std::ptrdiff_t>(beyond.size()), general, by);
    for (const std::size_t i : beyond) text += "  not " + label(study.rows[i]) + "\n";
  };
  list("", "a method of the product");
  list("rigid", "the product's contact mechanics alone (without the closed form)");
  return text;
}

std::string csv_text(const std::vector<Study>& studies) {
  std::string text =
      "study,method,parameter,cost_us,rms,worst,thesis_rms,thesis_worst,error_unit,source,verdict,remark\n";
  for (const Study& study : studies) {
    const auto verdicts = dominated(study);
    for (std::size_t i = 0; i < study.rows.size(); ++i) {
      const Row& row = study.rows[i];
      text += fmt::format("{},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},{},{},{},{}\n", study.name,
                          field(row.method), row.parameter, row.cost_us, row.practical.rms,
                          row.practical.worst, row.thesis.rms, row.thesis.worst, field(study.unit),
                          name(row.source), field(verdict(study, verdicts[i])), field(row.remark));
    }
  }
  return text;
}

std::string json_lines(const std::vector<Study>& studies) {
  std::string text;
  for (const Study& study : studies) {
    const auto verdicts = dominated(study);
    for (std::size_t i = 0; i < study.rows.size(); ++i) {
      const Row& row = study.rows[i];
      // No name or remark has a character that JSON would want escaped.
      text += fmt::format(
          R"({{"study":"{}","method":"{}","parameter":"{}","cost_us":{},"rms":{},"worst":{},"thesis_rms":{},)"
          R"("thesis_worst":{},"error_unit":"{}","source":"{}","verdict":"{}","remark":"{}"}})"
          "\n",
          study.name, row.method, row.parameter, row.cost_us, row.practical.rms, row.practical.worst,
          row.thesis.rms, row.thesis.worst, study.unit, name(row.source), verdict(study, verdicts[i]),
          row.remark);
    }
  }
  return text;
}

std::string ranges_text(const std::vector<Range>& ranges) {
  std::string text = "study,quantity,lowest,highest\n";
  for (const Range& r : ranges)
    text += fmt::format("{},{},{},{}\n", r.study, r.quantity, r.lowest, r.highest);
  return text;
}

std::string frontier_text(const std::vector<Study>& studies) {
  std::string text = "study,method,parameter,cost_us,error,error_unit,note\n";
  for (const Study& study : studies) {
    if (!study.shipped) continue;
    const auto verdicts = dominated(study);
    for (std::size_t i = 0; i < study.rows.size(); ++i) {
      const Row& row = study.rows[i];
      const std::string note =
          verdicts[i] ? "dominated by " + label(study.rows[verdicts[i]->by]) : "frontier";
      text += fmt::format("{},{},{},{:.3g},{:.3g},{},{}\n", study.name, row.method, row.parameter,
                          row.cost_us, error_of(row), field(study.unit), field(note));
    }
  }
  return text;
}

}  // namespace strobe::studies::trade
