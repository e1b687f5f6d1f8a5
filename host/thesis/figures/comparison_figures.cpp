// Figures 15 to 17: the approaches beside each other, and touchdown to lift-off by the in/out models.
#include <fmt/format.h>

#include <algorithm>

#include "common/impact/fit/model_fit.hpp"
#include "host/thesis/figures/figure_parts.hpp"

namespace strobe::report {

namespace {

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
                 int filled, int open, bool legend,
                 const std::function<bool(const impact::Observation&)>& chosen) {
  const auto add = [&](const char* model, int symbol, std::vector<PlotPoint> points) {
    const std::string name = fmt::format("{}, {}", who, model);
    panel.series.push_back({.name = name,
                            .legend = legend ? name : std::string(),
                            .stroke = Stroke::points,
                            .colour = colour,
                            .symbol = symbol,
                            .points = std::move(points)});
  };
  add("grip and offset", filled, scatter(data, data.offset, of, chosen));
  add("slides or rolls", open, scatter(data, data.rigid, of, chosen));
}

Panel in_out_panel(const InOut& data, const Sets& sets, Component of, const char* what, bool legend) {
  Panel panel{.x_label = fmt::format("{}, computed", what), .y_label = fmt::format("{}, measured", what)};
  if (sets.size() == 1) {
    const std::string own = sets.front().condition->name();
    add_scatter(panel, data, of, "other sets", "#bbbbbb", 7, 6, legend,
                [&](const impact::Observation& o) { return o.name != own; });
    const int symbol = symbol_of(sets.front());
    add_scatter(panel, data, of, label_of(sets.front()), colour_of(sets.front()), symbol, symbol - 1, legend,
                [&](const impact::Observation& o) { return o.name == own; });
  } else {
    for (const SetCurves& set : sets)
      add_scatter(panel, data, of, std::string(spin_phrase(set.condition->spin)), colour_of(set),
                  symbol_of(set), symbol_of(set) - 1, legend,
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

}  // namespace

std::vector<Figure> comparison_figures(const ThesisInputs& inputs, const Sets& sets) {
  return {approaches(15, sets, {Quantity::vx_mps, Quantity::vy_mps, Quantity::omega_radps}, "Velocities"),
          approaches(16, sets, {Quantity::fx_n, Quantity::fy_n}, "Forces"), in_out_figure(inputs, sets)};
}

}  // namespace strobe::report
