// Figures 4 to 14: each approach by itself.
#include "host/thesis/figures/figures.hpp"

#include <fmt/format.h>

#include "host/thesis/figures/figure_parts.hpp"

namespace strobe::report {

namespace {

constexpr const char* kBars = "bars: one sd of the images about their cubic";
constexpr const char* kEnds = "points: means at touchdown and lift-off ± printed sd";
constexpr const char* kScale = "; fractions of the mechanics' rotation";
constexpr const char* kFitBand = "bands: one sd of the fit";
constexpr const char* kShotBand = "bands: one sd of a single shot, from the printed sds";

Series cubic_series(const SetCurves& c, Quantity quantity, std::string legend) {
  return series_of(c, "cubic", std::move(legend), Stroke::solid, curve(c, Approach::cubic, quantity, true));
}

/// Images with their cubics.
Figure positions(int number, const Sets& sets, Quantity quantity, const char* what) {
  Figure figure{.number = number,
                .title = fmt::format("{}, with the cubics through the images: {}", what, labels_of(sets)),
                .caption = fmt::format("points: images in contact ({}); lines: least-squares cubics; {}{}",
                                       kBars, kFitBand, is_rotational(quantity) ? kScale : "")};
  Panel panel = time_panel(sets, quantity);
  for (const SetCurves& c : sets) {
    panel.series.push_back(
        series_of(c, "images", label_of(c) + ", measured", Stroke::points, measured(c, quantity)));
    panel.series.push_back(cubic_series(c, quantity, label_of(c) + ", cubic"));
  }
  figure.panels.push_back(std::move(panel));
  return figure;
}

Panel derivative_panel(const Sets& sets, Quantity quantity, bool legend) {
  Panel panel = time_panel(sets, quantity);
  panel.zero_line = true;
  for (const SetCurves& c : sets) {
    const auto named = [&](const char* what) { return legend ? label_of(c) + what : std::string(); };
    auto ends = measured_ends(c, quantity);
    if (!ends.empty())
      panel.series.push_back(series_of(c, "measured", named(", measured"), Stroke::points, std::move(ends)));
    panel.series.push_back(cubic_series(c, quantity, named(", differentiated")));
  }
  return panel;
}

Figure derivatives(int number, const Sets& sets, const std::vector<Quantity>& quantities, const char* what,
                   std::string caption) {
  Figure figure{.number = number,
                .title = fmt::format("{} by differentiation of the cubics: {}", what, labels_of(sets)),
                .caption = std::move(caption),
                .columns = static_cast<int>(quantities.size())};
  for (const Quantity q : quantities)
    figure.panels.push_back(derivative_panel(sets, q, figure.panels.empty()));
  return figure;
}

Panel integration_panel(const Sets& sets, Quantity quantity, bool legend) {
  Panel panel = time_panel(sets, quantity);
  panel.zero_line = quantity != Quantity::x_cm && quantity != Quantity::y_mm;
  for (const SetCurves& c : sets) {
    const auto add = [&](const char* kind, Stroke stroke, std::vector<PlotPoint> points) {
      const std::string named = legend ? fmt::format("{}, {}", label_of(c), kind) : std::string();
      if (!points.empty()) panel.series.push_back(series_of(c, kind, named, stroke, std::move(points)));
    };
    auto images = measured(c, quantity);
    if (images.empty()) images = measured_ends(c, quantity);
    add("measured", Stroke::points, std::move(images));
    if (is_rotational(quantity)) {
      add("integrated", Stroke::solid, curve(c, Approach::pulse_grip, quantity, true));
      add("mechanics", Stroke::dash_dotted, curve(c, Approach::mechanics, quantity, false));
      continue;
    }
    add("exact", Stroke::solid, curve(c, Approach::pulse_exact, quantity, true));
    add("simplified", Stroke::dashed, curve(c, Approach::pulse_simplified, quantity, false));
  }
  return panel;
}

Figure integrals(int number, const Sets& sets, const std::vector<Quantity>& quantities, const char* what,
                 const std::string& caption) {
  Figure figure{.number = number,
                .title = fmt::format("{} by integration of the damped sine pulse: {}", what, labels_of(sets)),
                .caption = fmt::format("{}; {}", caption, kShotBand),
                .columns = static_cast<int>(quantities.size())};
  for (const Quantity q : quantities)
    figure.panels.push_back(integration_panel(sets, q, figure.panels.empty()));
  return figure;
}

}  // namespace

std::vector<Figure> differentiation_figures(const Sets& sets) {
  const std::string ends = fmt::format("{}; {}", kEnds, kFitBand);
  return {
      positions(4, sets, Quantity::x_cm, "Distance along the surface"),
      positions(5, sets, Quantity::y_mm, "Drop of the top of the ball"),
      positions(6, sets, Quantity::rotation_deg, "Rotation"),
      derivatives(7, sets, {Quantity::vx_mps, Quantity::vy_mps}, "Velocities", ends),
      derivatives(8, sets, {Quantity::omega_radps, Quantity::slip_mps}, "Spin and slip", ends),
      derivatives(
          9, sets, {Quantity::fx_n, Quantity::fy_n}, "Forces",
          fmt::format("a cubic's force is a straight line: it cannot start and end at zero; {}", kFitBand)),
  };
}

std::vector<Figure> integration_figures(const Sets& sets) {
  return {
      integrals(10, sets, {Quantity::x_cm}, "Distance along the surface",
                fmt::format("points: images in contact ({})", kBars)),
      integrals(11, sets, {Quantity::y_mm}, "Drop",
                fmt::format("points: top of the ball ({}); lines: its centre", kBars)),
      integrals(12, sets, {Quantity::vx_mps, Quantity::vy_mps}, "Velocities", kEnds),
      integrals(13, sets, {Quantity::rotation_deg, Quantity::omega_radps, Quantity::slip_mps},
                "Rotation, spin and slip",
                "integrated: friction until the slip is zero, then rolling; images: fractions of the "
                "mechanics' rotation"),
      integrals(14, sets, {Quantity::fx_n, Quantity::fy_n}, "Forces", "friction: mu Fy throughout"),
  };
}

Result<std::vector<Figure>> figures(const ThesisInputs& inputs, const std::vector<std::string>& names) {
  Sets sets;
  for (const std::string& name : names) {
    auto curves = set_curves(inputs, name);
    if (!curves) return tl::unexpected(curves.error());
    sets.push_back(*std::move(curves));
  }
  std::vector<Figure> all = differentiation_figures(sets);
  for (Figure& figure : integration_figures(sets)) all.push_back(std::move(figure));
  for (Figure& figure : comparison_figures(inputs, sets)) all.push_back(std::move(figure));
  return all;
}

}  // namespace strobe::report
