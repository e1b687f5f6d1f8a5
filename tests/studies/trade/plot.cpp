#include "tests/studies/trade/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace strobe::studies::trade {

namespace {

constexpr int kColumns = 2;
constexpr int kPanelWidth = 830;
constexpr int kKeyWidth = 345;
constexpr int kPanelHeight = 470;
constexpr int kTop = 56;
/// Errors of rounding alone are drawn here.
constexpr double kFloor = 5e-17;

/// Told apart by the colour-blind too (Okabe and Ito).
constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                    "#E69F00", "#56B4E9", "#7A5C00", "#555555"};
constexpr int kSymbols[] = {7, 5, 9, 13, 11, 15, 6, 4, 8, 12, 10, 14};

std::string literal(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

double drawn(double error) { return std::max(error, kFloor); }

/// Rows of one method that differ in a number: a line.
bool swept(const Row& row) {
  for (const char* name : {"tolerance=", "steps=", "step_s=", "accuracy="})
    if (row.parameter.rfind(name, 0) == 0) return true;
  return false;
}

/// "tolerance=1e-06" as "1e-06", "effects=auto" as "auto".
std::string short_value(const std::string& parameter) {
  const auto at = parameter.find('=');
  return at == std::string::npos ? parameter : parameter.substr(at + 1);
}

struct Curve {
  std::string title;
  bool line = false, general = false;
  std::vector<const Row*> rows;
};

std::vector<Curve> curves_of(const Study& study) {
  std::vector<Curve> curves;
  for (const Row& row : study.rows) {
    const std::string title = swept(row) ? row.method : label(row);
    const auto known = std::ranges::find(curves, title, &Curve::title);
    Curve& curve = known == curves.end() ? curves.emplace_back() : *known;
    curve.title = title;
    curve.line = swept(row);
    curve.general = row.general;
    curve.rows.push_back(&row);
  }
  return curves;
}

/// The rows on the frontier as steps: what error can be had within a time.
std::string frontier_data(const Study& study) {
  const auto verdicts = dominated(study);
  std::vector<std::pair<double, double>> best;
  for (std::size_t i = 0; i < study.rows.size(); ++i)
    if (!verdicts[i]) best.emplace_back(study.rows[i].cost_us, drawn(error_of(study.rows[i])));
  std::ranges::sort(best);
  std::string text;
  double least = INFINITY;
  for (const auto& [cost, error] : best) {
    if (error >= least) continue;
    if (std::isfinite(least)) text += fmt::format("{:.4g} {:.4g}\n", cost, least);
    text += fmt::format("{:.4g} {:.4g}\n", cost, error);
    least = error;
  }
  return text;
}

/// First and last value of a curve are written beside it.
std::string labels_of(const Curve& curve) {
  std::string text;
  if (!curve.line || curve.general) return text;
  for (const Row* row : {curve.rows.front(), curve.rows.back()})
    text +=
        fmt::format("set label {} at {:.4g},{:.4g} left offset 0.6,0.5 font small textcolor rgb '#444444'\n",
                    literal(short_value(row->parameter)), row->cost_us, drawn(error_of(*row)));
  return text;
}

struct Range {
  double low = INFINITY, high = 0.0;
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  /// With room at the ends, of a decade's share.
  std::string text(double below, double above) const {
    return fmt::format("[{:.3g}:{:.3g}]", low * std::pow(10.0, -below), high * std::pow(10.0, above));
  }
};

std::string panel_text(const Study& study, std::size_t index, int width, int height) {
  const auto curves = curves_of(study);
  const int column = static_cast<int>(index) % kColumns;
  const int row = static_cast<int>(index) / kColumns;
  Range costs;
  Range errors;
  for (const Row& r : study.rows) {
    costs.add(r.cost_us);
    errors.add(drawn(error_of(r)));
  }
  const double decades = std::log10(costs.high / costs.low);
  std::string out = "\n";
  out +=
      fmt::format("set lmargin at screen {:.4f}; set rmargin at screen {:.4f}\n",
                  (column * kPanelWidth + 82.0) / width, ((column + 1.0) * kPanelWidth - kKeyWidth) / width);
  out += fmt::format("set tmargin at screen {:.4f}; set bmargin at screen {:.4f}\n",
                     1.0 - (kTop + row * kPanelHeight + 28.0) / height,
                     1.0 - (kTop + (row + 1) * kPanelHeight - 62.0) / height);
  out += fmt::format("set title {} offset 0,-0.6 noenhanced\n", literal(study.title));
  out += fmt::format("set xlabel 'microseconds a call' offset 0,0.3\nset ylabel {} offset 0.5,0 noenhanced\n",
                     literal("largest error " + study.unit));
  out += fmt::format("set key at screen {:.4f}, screen {:.4f} left top Left reverse\n",
                     ((column + 1.0) * kPanelWidth - kKeyWidth + 12.0) / width,
                     1.0 - (kTop + row * kPanelHeight + 26.0) / height);
  out += fmt::format("set xrange {}\nset yrange {}\n",
                     costs.text(0.06 * decades + 0.05, 0.12 * decades + 0.1), errors.text(0.3, 0.3));
  for (const Curve& curve : curves) out += labels_of(curve);
  std::string data, plots;
  data += "$frontier << EOD\n" + frontier_data(study) + "EOD\n";
  plots += "  $frontier using 1:2 with lines lw 6 lc rgb '#e4e4e4' title 'frontier', \\\n";
  for (std::size_t i = 0; i < curves.size(); ++i) {
    data += fmt::format("$curve{} << EOD\n", i);
    for (const Row* r : curves[i].rows)
      data += fmt::format("{:.4g} {:.4g}\n", r->cost_us, drawn(error_of(*r)));
    data += "EOD\n";
    const char* colour = kColours[i % std::size(kColours)];
    plots += fmt::format("  $curve{} using 1:2 with {} pt {} ps {} lw {} dt {} lc rgb '{}' title {}, \\\n", i,
                         curves[i].line ? "linespoints" : "points", kSymbols[i % std::size(kSymbols)],
                         curves[i].line ? 0.7 : 1.1, curves[i].general ? 1.0 : 1.8, curves[i].general ? 2 : 1,
                         colour, literal(curves[i].title));
  }
  plots.erase(plots.rfind(", \\"));
  return data + out + "plot \\\n" + plots + "\nunset label\n";
}

}  // namespace

std::string script_text(const std::vector<Study>& studies, const std::string& name) {
  const int rows = (static_cast<int>(studies.size()) + kColumns - 1) / kColumns;
  const int width = kColumns * kPanelWidth, height = kTop + rows * kPanelHeight;
  constexpr double kPngScale = 1.4;
  std::string body;
  for (std::size_t i = 0; i < studies.size(); ++i) body += panel_text(studies[i], i, width, height);
  std::string out = "# Error against cost. To draw it again: gnuplot on this file.\n";
  for (const char* kind : {"svg", "png"}) {
    const bool svg = std::string(kind) == "svg";
    out += "reset\nset encoding utf8\n";
    out += svg ? fmt::format(
                     "set terminal svg size {},{} font 'sans-serif,13' background '#ffffff'\nsmall = "
                     "'sans-serif,10'\n",
                     width, height)
               : fmt::format(
                     "set terminal pngcairo size {},{} font 'sans,10' fontscale {} linewidth {} "
                     "pointscale {} background '#ffffff'\nsmall = 'sans,8'\n",
                     std::lround(width * kPngScale), std::lround(height * kPngScale), kPngScale, kPngScale,
                     kPngScale);
    out += fmt::format("set output {}\nset multiplot\n", literal(name + "." + kind));
    out += "set logscale xy\nset format x '10^{%L}'\nset format y '10^{%L}'\n";
    out += "set border 3 lc rgb '#444444'; set tics nomirror out\n";
    out += "set grid lt 1 lw 0.5 lc rgb '#e8e8e8'\n";
    out += "set key font small noenhanced samplen 1.6 spacing 1.0 noopaque\n";
    out += fmt::format(
        "set label 99 'Error against cost of every method, and what can be had best' at screen 0.012,{:.4f} "
        "left front\n",
        1.0 - 22.0 / height);
    out += body + "unset multiplot\nset output\n";
  }
  return out;
}

Result<void> plot(const std::vector<Study>& studies, const std::string& name) {
  const std::string script = name + ".gp";
  std::ofstream file(script, std::ios::binary);
  file << script_text(studies, name);
  file.close();
  if (!file) return fail(script + ": cannot be written");
  std::string quoted;
  for (const char c : script) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  const std::string command = "gnuplot '" + quoted + "' > '" + quoted + ".log' 2>&1";
  if (std::system(command.c_str()) != 0)
    return fail("gnuplot (package gnuplot-nox) did not draw " + script + ": see " + script + ".log");
  std::remove((script + ".log").c_str());
  return {};
}

}  // namespace strobe::studies::trade
