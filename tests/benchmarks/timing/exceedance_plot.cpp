#include "tests/benchmarks/timing/exceedance_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "host/figures/svg.hpp"

namespace strobe::benchmarks::timing {

namespace {

/// Told apart by the colour-blind too (Okabe and Ito).
constexpr std::array<const char*, 8> kColours{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                              "#E69F00", "#56B4E9", "#7A5C00", "#555555"};
constexpr double kMinUs = 1e-3;
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

void draw(const std::string& svg, const std::vector<Panel>& panels) {
  figures::Figure figure{.title = "Shares of values above", .columns = static_cast<int>(panels.size())};
  for (const Panel& panel : panels) {
    figures::Panel& out = figure.panels.emplace_back();
    out.title = panel.title;
    out.x_label = panel.x_label;
    out.y_label = panel.y_label;
    out.log_x = panel.log_x;
    out.log_y = panel.log_y;
    for (std::size_t i = 0; i < panel.curves.size(); ++i) {
      const Curve& curve = panel.curves[i];
      figures::Series series{.name = panel.title + " " + curve.title,
                             .legend = &panel == &panels.front() ? curve.title : "",
                             .colour = kColours[i % kColours.size()]};
      for (std::size_t k = 0; k < curve.x.size(); ++k) series.points.push_back({curve.x[k], curve.y[k]});
      out.series.push_back(std::move(series));
    }
  }
  const std::filesystem::path file(svg);
  const auto drawn =
      figures::write_figure(figure, file.has_parent_path() ? file.parent_path() : ".", file.stem());
  if (!drawn) throw std::runtime_error(drawn.error().message);
}

}  // namespace strobe::benchmarks::timing
