#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/units/angles.hpp"
#include "host/figures/svg.hpp"
#include "tests/studies/digitize/studies.hpp"
#include "tests/studies/digitize/tables.hpp"

namespace strobe::studies::digitize {

namespace {

/// One value of each point, told apart by the colour-blind too (Okabe and Ito).
struct Curve {
  const char* title;
  const char* colour;
  double (*of)(const Score& s);
};

double share(double count, const Score& s) { return count / std::max(1, s.airborne); }

constexpr Curve kShares[] = {
    {"airborne found", "#0072B2", [](const Score& s) { return share(s.found, s); }},
    {"found or said to be unmeasured", "#56B4E9",
     [](const Score& s) { return share(s.found + s.reported, s); }},
    {"equators measured", "#009E73",
     [](const Score& s) { return s.lines_found / std::max(1.0, static_cast<double>(s.lines)); }},
    {"invented, of those there", "#D55E00", [](const Score& s) { return share(s.invented, s); }}};
constexpr Curve kErrors[] = {
    {"centre, px (.1)", "#0072B2", [](const Score& s) { return centre_rms_px(s); }},
    {"diameter, px (.2)", "#E69F00", [](const Score& s) { return s.diameter_px.rms(); }},
    {"equator, degrees (.2)", "#009E73", [](const Score& s) { return degrees(s.equator_rad.rms()); }}};
constexpr Curve kNormalized[] = {
    {"centre", "#0072B2", [](const Score& s) { return s.mahalanobis.normalized(); }},
    {"diameter", "#E69F00", [](const Score& s) { return s.diameter_px.normalized(); }},
    {"equator", "#009E73", [](const Score& s) { return s.equator_rad.normalized(); }}};

template <std::size_t N>
figures::Panel panel_of(const RobustnessAxis& axis, const std::vector<RobustnessPoint>& points,
                        const char* title, const Curve (&curves)[N], bool log_y, bool legend) {
  figures::Panel panel{
      .title = axis.name, .x_label = axis.what, .y_label = title, .log_x = axis.logarithmic, .log_y = log_y};
  for (const Curve& curve : curves) {
    figures::Series series{.name = axis.name + " " + curve.title,
                           .legend = legend ? std::string(title) + ": " + curve.title : std::string(),
                           .colour = curve.colour};
    for (const RobustnessPoint& p : points)
      if (p.axis == axis.name) series.points.push_back({p.value, curve.of(p.score)});
    panel.series.push_back(std::move(series));
  }
  return panel;
}

}  // namespace

Result<void> plot_robustness(const std::vector<RobustnessPoint>& points, const std::string& file) {
  figures::Figure figure{.title = "The digitizer on rendered photographs, one condition changed at a time",
                         .columns = 3};
  for (const RobustnessAxis& axis : robustness_axes()) {
    if (std::ranges::find(points, axis.name, &RobustnessPoint::axis) == points.end()) continue;
    const bool legend = figure.panels.empty();
    figure.panels.push_back(panel_of(axis, points, "share", kShares, false, legend));
    figure.panels.push_back(panel_of(axis, points, "rms error", kErrors, true, legend));
    figure.panels.push_back(panel_of(axis, points, "error over stated sd, rms", kNormalized, true, legend));
  }
  const std::filesystem::path path(file);
  return figures::write_figure(figure, path.has_parent_path() ? path.parent_path() : ".", path.stem());
}

}  // namespace strobe::studies::digitize
