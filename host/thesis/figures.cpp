#include "host/thesis/figures.hpp"

#include <fmt/format.h>

#include "host/thesis/curves.hpp"

namespace strobe::report {

namespace {

using impact::PulseForm;
using Sets = std::vector<SetCurves>;

constexpr const char* kTimeLabel = "time since touchdown, ms";
constexpr const char* kBars = "bars: one sd of the images about their cubic";
constexpr const char* kEnds = "points: means at touchdown and lift-off ± printed sd";

const char* colour_of(const SetCurves& c) {
  if (c.condition->spin == "top") return colours::kTop;
  return c.condition->spin == "back" ? colours::kBack : colours::kZero;
}

int symbol_of(const SetCurves& c) {
  if (c.condition->spin == "top") return 9;
  return c.condition->spin == "back" ? 5 : 7;
}

std::string label_of(const SetCurves& c) {
  return fmt::format("{} {}°", spin_phrase(c.condition->spin), c.condition->angle_label_deg);
}

Series series(const SetCurves& c, const std::string& kind, std::string legend, Stroke stroke,
              std::vector<PlotPoint> points) {
  return {.name = c.condition->name() + " " + kind,
          .legend = std::move(legend),
          .stroke = stroke,
          .colour = colour_of(c),
          .symbol = symbol_of(c),
          .points = std::move(points)};
}

Panel panel_of(Quantity quantity, std::string title = {}) {
  return {.title = std::move(title), .x_label = kTimeLabel, .y_label = axis_label(quantity)};
}

std::string spread_of(const Sets& sets) { return sets.size() > 1 ? "three spins" : label_of(sets.front()); }

/// Images with their cubics.
Figure position_by_cubic(int number, const Sets& sets, Quantity quantity, const char* what) {
  Figure figure{
      .number = number,
      .title = fmt::format("{} of the images in contact, cubics through them: {}", what, spread_of(sets)),
      .caption = fmt::format("points: images ({}); lines: least-squares cubics", kBars)};
  Panel panel = panel_of(quantity);
  for (const SetCurves& c : sets) {
    panel.series.push_back(
        series(c, "images", label_of(c) + ", measured", Stroke::points, measured(c, quantity)));
    panel.series.push_back(
        series(c, "cubic", label_of(c) + ", cubic", Stroke::solid, differentiated(c, quantity)));
  }
  figure.legend_columns = 3;
  figure.panels.push_back(std::move(panel));
  return figure;
}

Panel derivative_panel(const Sets& sets, Quantity quantity, bool legend) {
  Panel panel = panel_of(quantity);
  panel.zero_line = true;
  for (const SetCurves& c : sets) {
    auto ends = measured_ends(c, quantity);
    if (!ends.empty())
      panel.series.push_back(
          series(c, "ends", legend ? label_of(c) + ", measured" : "", Stroke::points, std::move(ends)));
    panel.series.push_back(series(c, "cubic's derivative", legend ? label_of(c) + ", differentiated" : "",
                                  Stroke::solid, differentiated(c, quantity)));
  }
  return panel;
}

Figure derivatives(int number, const Sets& sets, std::vector<Quantity> quantities, const char* what,
                   const char* caption) {
  Figure figure{.number = number,
                .title = fmt::format("{} by differentiation: {}", what, spread_of(sets)),
                .caption = caption};
  figure.columns = static_cast<int>(quantities.size());
  bool legend = true;
  for (const Quantity q : quantities) {
    figure.panels.push_back(derivative_panel(sets, q, legend));
    legend = false;
  }
  return figure;
}

Panel integration_panel(const Sets& sets, Quantity quantity, bool legend) {
  Panel panel = panel_of(quantity);
  const bool signed_quantity = quantity != Quantity::x_cm && quantity != Quantity::y_mm;
  panel.zero_line = signed_quantity;
  for (const SetCurves& c : sets) {
    auto images = measured(c, quantity);
    if (images.empty()) images = measured_ends(c, quantity);
    const auto named = [&](const char* what) { return legend ? label_of(c) + what : std::string(); };
    if (!images.empty())
      panel.series.push_back(series(c, "measured", named(", measured"), Stroke::points, std::move(images)));
    panel.series.push_back(
        series(c, "exact", named(", exact"), Stroke::solid, integrated(c, PulseForm::exact, quantity, true)));
    panel.series.push_back(series(c, "simplified", named(", simplified"), Stroke::dashed,
                                  integrated(c, PulseForm::simplified, quantity, false)));
  }
  return panel;
}

Figure integrals(int number, const Sets& sets, std::vector<Quantity> quantities, const char* what,
                 std::string caption) {
  Figure figure{.number = number,
                .title = fmt::format("{} by integration of the damped sine pulse: {}", what, spread_of(sets)),
                .caption = std::move(caption)};
  figure.columns = static_cast<int>(quantities.size());
  bool legend = true;
  for (const Quantity q : quantities) {
    figure.panels.push_back(integration_panel(sets, q, legend));
    legend = false;
  }
  return figure;
}

}  // namespace

Result<std::vector<Figure>> figures(const Material& material, const std::vector<std::string>& names) {
  Sets sets;
  for (const std::string& name : names) {
    auto curves = set_curves(material, name);
    if (!curves) return tl::unexpected(curves.error());
    sets.push_back(*std::move(curves));
  }
  constexpr const char* kBand = "bands: one sd of a single shot, from the printed sds";
  std::vector<Figure> all;
  all.push_back(position_by_cubic(4, sets, Quantity::x_cm, "Distance along the surface"));
  all.push_back(position_by_cubic(5, sets, Quantity::y_mm, "Drop of the top of the ball"));
  all.push_back(position_by_cubic(6, sets, Quantity::rotation_deg, "Rotation"));
  all.push_back(derivatives(7, sets, {Quantity::vx_mps, Quantity::vy_mps}, "Velocities", kEnds));
  all.push_back(derivatives(8, sets, {Quantity::omega_radps, Quantity::slip_mps}, "Spin and slip", kEnds));
  all.push_back(derivatives(9, sets, {Quantity::fx_n, Quantity::fy_n}, "Forces",
                            "a cubic's force is a straight line: it neither starts nor ends at zero"));
  all.push_back(integrals(10, sets, {Quantity::x_cm}, "Distance along the surface",
                          fmt::format("points: images ({}); {}", kBars, kBand)));
  all.push_back(integrals(11, sets, {Quantity::y_mm}, "Drop",
                          fmt::format("points: top of the ball ({}); lines: its centre; {}", kBars, kBand)));
  all.push_back(integrals(12, sets, {Quantity::vx_mps, Quantity::vy_mps}, "Velocities",
                          fmt::format("{}; {}", kEnds, kBand)));
  all.push_back(integrals(13, sets, {Quantity::rotation_deg, Quantity::omega_radps}, "Rotation and spin",
                          fmt::format("{}; {}", kEnds, kBand)));
  all.push_back(integrals(14, sets, {Quantity::fx_n, Quantity::fy_n}, "Forces", kBand));
  return all;
}

}  // namespace strobe::report
