#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "common/units/angles.hpp"
#include "tests/studies/digitize/studies.hpp"
#include "tests/studies/digitize/tables.hpp"

namespace strobe::studies::digitize {

namespace {

constexpr int kPanelWidth = 400;
constexpr int kPanelHeight = 280;
constexpr int kColumns = 4;
constexpr int kTop = 60;

/// Told apart by the colour-blind too (Okabe and Ito).
struct Curve {
  const char* title;
  const char* colour;
  int column;
};
constexpr Curve kShares[] = {{"airborne found", "#0072B2", 2},
                             {"found or said to be unmeasured", "#56B4E9", 3},
                             {"equators measured", "#009E73", 4},
                             {"invented, of those there", "#D55E00", 5}};
constexpr Curve kErrors[] = {{"centre [px] (.1)", "#0072B2", 6},
                             {"diameter [px] (.2)", "#E69F00", 7},
                             {"equator [degrees] (.2)", "#009E73", 8}};
constexpr Curve kNormalized[] = {
    {"centre", "#0072B2", 9}, {"diameter", "#E69F00", 10}, {"equator", "#009E73", 11}};

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.5g}", value) : "NaN"; }

std::string row(const RobustnessPoint& p) {
  const Score& s = p.score;
  const double airborne = std::max(1, s.airborne);
  std::string text = p.label;
  for (const double value :
       {s.found / airborne, (s.found + s.reported) / airborne,
        s.lines_found / std::max(1.0, static_cast<double>(s.lines)), s.invented / airborne, centre_rms_px(s),
        s.diameter_px.rms(), degrees(s.equator_rad.rms()), s.mahalanobis.normalized(),
        s.diameter_px.normalized(), s.equator_rad.normalized()})
    text += fmt::format(" {}", number(value));
  return text + "\n";
}

template <std::size_t N>
std::string curves(const std::string& data, const Curve (&of)[N]) {
  std::string text = "plot ";
  for (const Curve& c : of)
    text += fmt::format("{} using 1:{} with linespoints pt 7 ps 0.6 lw 1.8 lc rgb '{}' title '{}', ", data,
                        c.column, c.colour, c.title);
  text.erase(text.rfind(", "));
  return text + "\n";
}

/// Left to right by the axis, three panels below each other in each of two bands.
std::string place(std::size_t axis, int panel, int width, int height) {
  const int column = static_cast<int>(axis) % kColumns;
  const int row = static_cast<int>(axis) / kColumns * 3 + panel;
  return fmt::format("set lmargin at screen {:.4f}; set rmargin at screen {:.4f}\n",
                     (column * kPanelWidth + 62.0) / width, ((column + 1.0) * kPanelWidth - 14.0) / width) +
         fmt::format("set tmargin at screen {:.4f}; set bmargin at screen {:.4f}\n",
                     1.0 - (kTop + row * kPanelHeight + 30.0) / height,
                     1.0 - (kTop + (row + 1.0) * kPanelHeight - 52.0) / height);
}

std::string panels(const RobustnessAxis& axis, std::size_t index, const std::vector<RobustnessPoint>& points,
                   int width, int height) {
  const std::string data = "$" + axis.name;
  std::string text = data + " << EOD\n";
  for (const RobustnessPoint& p : points)
    if (p.axis == axis.name) text += row(p);
  text += "EOD\nunset logscale\n";
  text += axis.logarithmic ? "set logscale x\n" : "";
  text += fmt::format(
      "set xlabel '{}' offset 0,0.4\nset autoscale xfix\nset offsets graph 0.03, graph 0.03, 0, 0\n",
      axis.what);
  const std::string key = index == 0 ? "set key center left Left reverse noopaque\n" : "unset key\n";
  text += place(index, 0, width, height) + key + "set title 'share'\nset yrange [-0.03:1.08]\n" +
          curves(data, kShares) + "unset label 99\n";
  text += place(index, 1, width, height) + (index == 0 ? "set key top left Left reverse opaque\n" : "") +
          "set title 'rms error'\nset logscale y\nset yrange [0.01:10]\n" + curves(data, kErrors);
  text += place(index, 2, width, height) + "set title 'error over stated sd, rms'\nset yrange [0.2:20]\n" +
          curves(data, kNormalized);
  return text;
}

std::string script_text(const std::vector<RobustnessPoint>& points, const std::string& file) {
  std::vector<RobustnessAxis> axes;
  for (const RobustnessAxis& axis : robustness_axes())
    if (std::ranges::any_of(points, [&](const auto& p) { return p.axis == axis.name; })) axes.push_back(axis);
  const int bands = (static_cast<int>(axes.size()) + kColumns - 1) / kColumns;
  const int width = kPanelWidth * std::min(kColumns, static_cast<int>(axes.size()));
  const int height = kTop + 3 * bands * kPanelHeight;
  std::string text = "set encoding utf8\n";
  text += file.ends_with(".png")
              ? fmt::format("set terminal pngcairo size {},{} font 'sans,10' background '#ffffff'\n", width,
                            height)
              : fmt::format("set terminal svg size {},{} font 'sans-serif,12' background '#ffffff'\n", width,
                            height);
  text += fmt::format("set output '{}'\nset multiplot\n", file);
  text += "set border 3 lc rgb '#444444'; set tics nomirror out\nset grid lt 1 lw 0.5 lc rgb '#e8e8e8'\n";
  text += fmt::format(
      "set label 99 'The digitizer on rendered photographs, one condition changed at a time' at "
      "screen 0.02,{:.4f} left front\n",
      1.0 - 22.0 / height);
  for (std::size_t i = 0; i < axes.size(); ++i) text += panels(axes[i], i, points, width, height);
  return text + "unset multiplot\nset output\n";
}

}  // namespace

Result<void> plot_robustness(const std::vector<RobustnessPoint>& points, const std::string& file) {
  if (file.find('\'') != std::string::npos) return fail(file + ": no quotes in the name of a plot, please");
  const std::string script = file + ".gp";
  std::ofstream out(script, std::ios::binary);
  out << script_text(points, file);
  out.close();
  if (!out) return fail(script + ": cannot be written");
  if (std::system(("gnuplot '" + script + "' > '" + script + ".log' 2>&1").c_str()) != 0)
    return fail("gnuplot (package gnuplot-nox) did not draw " + script + ": see " + script + ".log");
  std::remove((script + ".log").c_str());
  std::remove(script.c_str());
  return {};
}

}  // namespace strobe::studies::digitize
