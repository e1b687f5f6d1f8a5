#include "host/bounces/figure.hpp"

#include <algorithm>
#include <string>

namespace strobe::bounces {

namespace {

constexpr std::array<const char*, kModels.size()> kColours{
    report::colours::kConstrained, report::colours::kCubic, report::colours::kZero, report::colours::kTop};
constexpr std::array<int, kModels.size()> kSymbols{4, 8, 6, 7};  // gnuplot's: hollow but for the last

report::Panel panel_of(const std::vector<Row>& rows, published::Build build, const char* title, bool legend) {
  report::Panel panel{
      .title = title, .x_label = "measured topspin, rad/s", .y_label = "predicted topspin, rad/s"};
  double most = 1.0;
  for (std::size_t i = 0; i < kModels.size(); ++i) {
    const std::string model(name(kModels[i]));
    report::Series series{.name = std::string(title) + " " + model,
                          .legend = legend ? model : std::string(),
                          .stroke = report::Stroke::points,
                          .colour = kColours[i],
                          .symbol = kSymbols[i]};
    for (const Row& row : rows) {
      if (row.bounce.ball.build != build) continue;
      series.points.push_back(
          {.x = -row.bounce.bounce.omega_lo_radps.value, .y = -row.predictions[i].lift_off.omega_radps});
      most = std::max({most, series.points.back().x, series.points.back().y});
    }
    panel.series.push_back(std::move(series));
  }
  panel.series.insert(panel.series.begin(), {.name = std::string(title) + " equal",
                                             .legend = legend ? "predicted = measured" : "",
                                             .stroke = report::Stroke::solid,
                                             .colour = "#888888",
                                             .points = {{0.0, 0.0}, {most, most}}});
  return panel;
}

}  // namespace

report::Figure spin_figure(const std::vector<Row>& rows) {
  report::Figure figure{.number = 1,
                        .title = "Spin after the bounces that others have published",
                        .caption = "Predicted before anything is fitted; models as in strobe bounces.",
                        .legend_columns = 5};
  const auto add_panel = [&](published::Build build, const char* title) {
    const auto of_build = [build](const Row& row) { return row.bounce.ball.build == build; };
    if (std::ranges::any_of(rows, of_build))
      figure.panels.push_back(panel_of(rows, build, title, figure.panels.empty()));
  };
  add_panel(published::Build::shell, "tennis ball");
  add_panel(published::Build::solid, "solid balls");
  figure.columns = static_cast<int>(figure.panels.size());
  return figure;
}

}  // namespace strobe::bounces
