#include "host/thesis/figures/figure_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace strobe::report {

const char* colour_of(const SetCurves& set) {
  if (set.condition->spin == "top") return colours::kTop;
  return set.condition->spin == "back" ? colours::kBack : colours::kZero;
}

int symbol_of(const SetCurves& set) {
  if (set.condition->spin == "top") return 9;
  return set.condition->spin == "back" ? 5 : 7;
}

std::string label_of(const SetCurves& set) {
  return fmt::format("{} {}°", spin_phrase(set.condition->spin), set.condition->angle_label_deg);
}

std::string labels_of(const Sets& sets) { return sets.size() > 1 ? "three spins" : label_of(sets.front()); }

Series series_of(const SetCurves& set, const std::string& kind, std::string legend, Stroke stroke,
                 std::vector<PlotPoint> points) {
  return {.name = set.condition->name() + " " + kind,
          .legend = std::move(legend),
          .stroke = stroke,
          .colour = colour_of(set),
          .symbol = symbol_of(set),
          .points = std::move(points)};
}

Panel time_panel(const Sets& sets, Quantity quantity) {
  double longest_ms = 0.0;
  for (const SetCurves& set : sets) longest_ms = std::max(longest_ms, set.dwell_ms);
  Panel panel{.x_label = "time since touchdown, ms", .y_label = axis_label(quantity)};
  // A little more than the contact, so that marks at its ends are not cut in half.
  panel.x_range = {-0.02 * longest_ms, 1.03 * longest_ms};
  return panel;
}

}  // namespace strobe::report
