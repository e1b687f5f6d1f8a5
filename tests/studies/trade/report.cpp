#include "tests/studies/trade/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

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

/// Rows of one method that differ in a number are a line.
bool is_swept(const Row& row) {
  for (const char* name : {"tolerance=", "steps=", "step_s=", "accuracy="})
    if (row.parameter.starts_with(name)) return true;
  return false;
}

/// Errors of rounding alone are drawn at the floor.
figures::PlotPoint point_of(const Row& row) {
  constexpr double kFloor = 5e-17;
  return {row.cost_us, std::max(error_of(row), kFloor)};
}

/// What error can be had within a time.
figures::Series frontier_series(const Study& study) {
  const auto verdicts = dominated(study);
  std::vector<figures::PlotPoint> best;
  for (std::size_t i = 0; i < study.rows.size(); ++i)
    if (!verdicts[i]) best.push_back(point_of(study.rows[i]));
  std::ranges::sort(best, {}, &figures::PlotPoint::x);
  figures::Series steps{.name = study.name + " frontier", .legend = "", .colour = "#bbbbbb"};
  for (const figures::PlotPoint& p : best) {
    if (!steps.points.empty() && p.y >= steps.points.back().y) continue;
    if (!steps.points.empty()) steps.points.push_back({p.x, steps.points.back().y});
    steps.points.push_back(p);
  }
  return steps;
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

figures::Figure figure_of(const std::vector<Study>& studies) {
  // Told apart by the colour-blind too (Okabe and Ito).
  constexpr std::array kColours{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                "#E69F00", "#56B4E9", "#7A5C00", "#555555"};
  constexpr std::array kSymbols{figures::Symbol::circle, figures::Symbol::square, figures::Symbol::triangle};
  figures::Figure figure{.title = "Error against cost of every method, and what can be had best",
                         .caption = "grey: the frontier; lines: one method at several tolerances or steps",
                         .columns = 2,
                         .legend_columns = 4};
  std::vector<std::string> methods;  // of all panels, so that each has one look
  for (const Study& study : studies) {
    if (!study.drawn) continue;
    figures::Panel panel{.title = study.title,
                         .x_label = "microseconds a call",
                         .y_label = "largest error " + study.unit,
                         .series = {frontier_series(study)},
                         .log_x = true,
                         .log_y = true};
    for (auto row = study.rows.begin(); row != study.rows.end();) {
      const std::string method = is_swept(*row) ? row->method : label(*row);
      const bool is_new = std::ranges::find(methods, method) == methods.end();
      if (is_new) methods.push_back(method);
      const auto look = static_cast<std::size_t>(std::ranges::find(methods, method) - methods.begin());
      const std::string name = study.name + " " + method;
      figures::Series points{.name = name,
                             .legend = is_new ? method : "",
                             .stroke = figures::Stroke::points,
                             .colour = kColours[look % kColours.size()],
                             .symbol = kSymbols[look / kColours.size() % kSymbols.size()]};
      for (; row != study.rows.end() && (is_swept(*row) ? row->method : label(*row)) == method; ++row)
        points.points.push_back(point_of(*row));
      figures::Series line = points;
      line.legend.clear();
      line.stroke = figures::Stroke::dotted;
      if (points.points.size() > 1) panel.series.push_back(std::move(line));
      panel.series.push_back(std::move(points));
    }
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace strobe::studies::trade
