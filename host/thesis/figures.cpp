#include "host/thesis/figures.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/impact/fit/model_fit.hpp"
#include "host/thesis/curves.hpp"

namespace strobe::thesis {

namespace {

using figures::Figure;
using figures::Panel;
using figures::PlotPoint;
using figures::Series;
using figures::Stroke;
using figures::Symbol;
namespace colours = figures::colours;

using Sets = std::vector<SetCurves>;

const char* colour_of(const SetCurves& set) {
  if (set.condition->spin == "top") return colours::kTop;
  return set.condition->spin == "back" ? colours::kBack : colours::kZero;
}

Symbol symbol_of(const SetCurves& set) {
  if (set.condition->spin == "top") return Symbol::triangle;
  return set.condition->spin == "back" ? Symbol::square : Symbol::circle;
}

/// "topspin 23°"
std::string label_of(const SetCurves& set) {
  return fmt::format("{} {}°", spin_phrase(set.condition->spin), set.condition->angle_label_deg);
}

/// That of one set, or of all.
std::string labels_of(const Sets& sets) { return sets.size() > 1 ? "three spins" : label_of(sets.front()); }

/// In the colour and with the symbol of its spin.
Series series_of(const SetCurves& set, const std::string& kind, std::string legend, Stroke stroke,
                 std::vector<PlotPoint> points) {
  return {.name = set.condition->name() + " " + kind,
          .legend = std::move(legend),
          .stroke = stroke,
          .colour = colour_of(set),
          .symbol = symbol_of(set),
          .points = std::move(points)};
}

/// Over time since touchdown, up to the longest dwell time of the sets.
Panel time_panel(const Sets& sets, Quantity quantity) {
  double longest_ms = 0.0;
  for (const SetCurves& set : sets) longest_ms = std::max(longest_ms, set.dwell_ms);
  Panel panel{.x_label = "time since touchdown, ms", .y_label = axis_label(quantity)};
  // A little more than the contact, so that marks at its ends are not cut in half.
  panel.x_range = {-0.02 * longest_ms, 1.03 * longest_ms};
  return panel;
}

// Figures 4 to 14: each approach by itself.

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

// Figures 15 to 17: the approaches beside each other, and touchdown to lift-off by the in/out models.

struct Method {
  Approach approach;
  const char* name;
  const char* colour;
  Stroke stroke;
  bool band;
};

constexpr Method kMethods[] = {
    {Approach::cubic, "differentiation, cubic", colours::kCubic, Stroke::solid, true},
    {Approach::spline, "differentiation, spline with the end velocities", colours::kConstrained,
     Stroke::dashed, true},
    {Approach::pulse_exact, "integration, friction throughout", colours::kIntegration, Stroke::solid, false},
    {Approach::pulse_grip, "integration, with grip", colours::kIntegration, Stroke::dotted, false},
    {Approach::mechanics, "mechanics: springs, friction, offset", colours::kMechanics, Stroke::dash_dotted,
     false},
};

Panel methods_panel(const SetCurves& set, Quantity quantity, bool legend) {
  Panel panel = time_panel({set}, quantity);
  panel.zero_line = true;
  panel.y_label = short_label(quantity);
  const auto add = [&](const std::string& name, const char* colour, Stroke stroke,
                       std::vector<PlotPoint> points) {
    if (points.empty()) return;
    panel.series.push_back({.name = set.condition->name() + " " + name,
                            .legend = legend ? name : std::string(),
                            .stroke = stroke,
                            .colour = colour,
                            .symbol = symbol_of(set),
                            .points = std::move(points)});
  };
  for (const Method& m : kMethods) add(m.name, m.colour, m.stroke, curve(set, m.approach, quantity, m.band));
  add("measured at touchdown and lift-off ± sd", colours::kMeasured, Stroke::points,
      measured_ends(set, quantity));
  return panel;
}

/// A row for each quantity, a column for each set.
Figure approaches(int number, const Sets& sets, const std::vector<Quantity>& quantities, const char* what) {
  Figure figure{.number = number,
                .title = fmt::format("{} by both approaches: {}", what, labels_of(sets)),
                .caption = "lines: computed; bands: one sd of the fit; measured: printed means ± sd"};
  figure.columns = static_cast<int>(sets.size() > 1 ? sets.size() : quantities.size());
  figure.legend_columns = 2;
  for (const Quantity q : quantities) {
    for (const SetCurves& set : sets) {
      // The first panel has the methods without spin as well, so that its legend holds all of them.
      Panel panel = methods_panel(set, q, figure.panels.empty());
      if (q == quantities.front() || sets.size() == 1) panel.title = label_of(set);
      figure.panels.push_back(std::move(panel));
    }
  }
  return figure;
}

/// The models' lift-off against the measured one, for all sets.
struct InOut {
  std::vector<impact::Observation> observations;
  std::vector<impact::Comparison> rigid;
  std::vector<impact::Comparison> offset;
};

std::optional<InOut> in_out(const ThesisInputs& inputs) {
  InOut out;
  out.observations = impact::observations_of(inputs.used.conditions, impact::Spread::replicate);
  const auto rigid = impact::fit(out.observations, impact::default_options(impact::ReboundModel::slide_roll));
  const auto offset =
      impact::fit(out.observations, impact::default_options(impact::ReboundModel::grip_offset));
  if (!rigid || !offset) return std::nullopt;
  out.rigid = rigid->comparisons;
  out.offset = offset->comparisons;
  return out;
}

using Component = double impact::Motion::*;

std::vector<PlotPoint> scatter(const InOut& data, const std::vector<impact::Comparison>& model, Component of,
                               const std::function<bool(const impact::Observation&)>& chosen) {
  std::vector<PlotPoint> points;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const impact::Observation& o = data.observations[i];
    if (!chosen(o)) continue;
    const double sd = o.lift_off_sd.*of;
    const double y = o.lift_off.*of;
    points.push_back({model[i].predicted.lift_off.*of, y, y - sd, y + sd});
  }
  return points;
}

void add_scatter(Panel& panel, const InOut& data, Component of, const std::string& who, const char* colour,
                 Symbol symbol, bool legend, const std::function<bool(const impact::Observation&)>& chosen) {
  const auto add = [&](const char* model, Symbol mark, std::vector<PlotPoint> points) {
    const std::string name = fmt::format("{}, {}", who, model);
    panel.series.push_back({.name = name,
                            .legend = legend ? name : std::string(),
                            .stroke = Stroke::points,
                            .colour = colour,
                            .symbol = mark,
                            .points = std::move(points)});
  };
  add("grip and offset", symbol, scatter(data, data.offset, of, chosen));
  add("slides or rolls", open_symbol(symbol), scatter(data, data.rigid, of, chosen));
}

Panel in_out_panel(const InOut& data, const Sets& sets, Component of, const char* what, bool legend) {
  Panel panel{.x_label = fmt::format("{}, computed", what), .y_label = fmt::format("{}, measured", what)};
  if (sets.size() == 1) {
    const std::string own = sets.front().condition->name();
    add_scatter(panel, data, of, "other sets", "#bbbbbb", Symbol::circle, legend,
                [&](const impact::Observation& o) { return o.name != own; });
    add_scatter(panel, data, of, label_of(sets.front()), colour_of(sets.front()), symbol_of(sets.front()),
                legend, [&](const impact::Observation& o) { return o.name == own; });
  } else {
    for (const SetCurves& set : sets)
      add_scatter(panel, data, of, std::string(spin_phrase(set.condition->spin)), colour_of(set),
                  symbol_of(set), legend,
                  [&](const impact::Observation& o) { return o.spin == set.condition->spin; });
  }
  double low = 0.0;
  double high = 0.0;
  for (const Series& s : panel.series)
    for (const PlotPoint& p : s.points) {
      low = std::min({low, p.x, p.low});
      high = std::max({high, p.x, p.high});
    }
  const double margin = 0.03 * (high - low);
  panel.x_range = panel.y_range = std::pair(low - margin, high + margin);
  // First, so that the points lie over it.
  panel.series.insert(panel.series.begin(),
                      {.name = "equal",
                       .legend = "",
                       .stroke = Stroke::solid,
                       .colour = "#888888",
                       .points = {{low - margin, low - margin}, {high + margin, high + margin}}});
  return panel;
}

Figure in_out_figure(const ThesisInputs& inputs, const Sets& sets) {
  Figure figure{
      .number = 17,
      .title = "Speed and spin at lift-off from those at touchdown, all 21 sets",
      .caption =
          "bars: printed sd of the measured means; line: computed = measured; models fitted to all sets",
      .columns = 2};
  const auto data = in_out(inputs);
  if (!data) return figure;
  figure.panels.push_back(in_out_panel(*data, sets, &impact::Motion::vx_mps, "vx at lift-off, m/s", true));
  figure.panels.push_back(
      in_out_panel(*data, sets, &impact::Motion::omega_radps, "spin at lift-off, rad/s", false));
  figure.legend_columns = sets.size() == 1 ? 2 : 3;
  return figure;
}

std::vector<Figure> comparison_figures(const ThesisInputs& inputs, const Sets& sets) {
  return {approaches(15, sets, {Quantity::vx_mps, Quantity::vy_mps, Quantity::omega_radps}, "Velocities"),
          approaches(16, sets, {Quantity::fx_n, Quantity::fy_n}, "Forces"), in_out_figure(inputs, sets)};
}

}  // namespace

Result<std::vector<Figure>> make_figures(const ThesisInputs& inputs, const std::vector<std::string>& names) {
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

}  // namespace strobe::thesis
