#include "tests/benchmarks/timing/exceedance_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

namespace strobe::benchmarks::timing {

namespace {

/// Told apart by the colour-blind too (Okabe and Ito).
constexpr std::array<const char*, 8> kColours{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                              "#E69F00", "#56B4E9", "#7A5C00", "#555555"};
constexpr double kMinUs = 1e-3;
constexpr int kPanelWidth = 560;

/// As a string of gnuplot's, in single quotes.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

void draw_panel(FILE* gnuplot, const Panel& panel) {
  std::fprintf(gnuplot, "unset logscale\nset title %s\nset xlabel %s\nset ylabel %s\n",
               quoted(panel.title).c_str(), quoted(panel.x_label).c_str(), quoted(panel.y_label).c_str());
  if (panel.log_x) std::fprintf(gnuplot, "set logscale x\n");
  if (panel.log_y) std::fprintf(gnuplot, "set logscale y\n");
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    std::fprintf(gnuplot, "$curve%zu << EOD\n", i);
    const Curve& curve = panel.curves[i];
    for (std::size_t k = 0; k < curve.x.size(); ++k)
      std::fprintf(gnuplot, "%.9g %.9g\n", curve.x[k], curve.y[k]);
    std::fprintf(gnuplot, "EOD\n");
  }
  std::fprintf(gnuplot, "plot ");
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    std::fprintf(gnuplot, "%s$curve%zu with linespoints pt 7 ps 0.4 lw 2 lc rgb '%s' title %s",
                 i == 0 ? "" : ", ", i, kColours[i % kColours.size()], quoted(panel.curves[i].title).c_str());
  }
  std::fprintf(gnuplot, "\n");
}

}  // namespace

Curve exceedance(const std::string& title, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  Curve curve{title, {}, {}};
  // Points at equal steps of the share's logarithm: the tail has as many as the bulk.
  for (double share = 1.0; share >= 1.0 / std::max(1.0, n); share *= 0.93) {
    const auto rank = static_cast<std::size_t>(std::max(0.0, std::ceil((1.0 - share) * n) - 1.0));
    if (rank >= values.size()) break;
    curve.x.push_back(std::max(values[rank], kMinUs));
    curve.y.push_back(share);
  }
  return curve;
}

void draw(const std::string& png, const std::vector<Panel>& panels) {
  const std::unique_ptr<FILE, int (*)(FILE*)> gnuplot(popen("gnuplot", "w"), &pclose);
  if (!gnuplot) throw std::runtime_error("gnuplot cannot be started (Debian package gnuplot-nox)");
  std::fprintf(
      gnuplot.get(),
      "set terminal pngcairo size %d,480 font 'sans,10'\nset output %s\nset grid\nset key top right\n"
      "set multiplot layout 1,%zu\n",
      kPanelWidth * static_cast<int>(panels.size()), quoted(png).c_str(), panels.size());
  for (const Panel& panel : panels) draw_panel(gnuplot.get(), panel);
  std::fprintf(gnuplot.get(), "unset multiplot\n");
}

}  // namespace strobe::benchmarks::timing
