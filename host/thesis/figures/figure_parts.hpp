// Parts shared by the figures. Pure; thread-safe.
#pragma once

#include <string>
#include <vector>

#include "host/thesis/figures/curves.hpp"
#include "host/thesis/figures/plot.hpp"

namespace strobe::report {

using Sets = std::vector<SetCurves>;

const char* colour_of(const SetCurves& set);
int symbol_of(const SetCurves& set);
std::string label_of(const SetCurves& set);  ///< "topspin 23°"
std::string labels_of(const Sets& sets);     ///< that of one set, or "three spins"

/// In the colour and with the symbol of its spin.
Series series_of(const SetCurves& set, const std::string& kind, std::string legend, Stroke stroke,
                 std::vector<PlotPoint> points);

/// Over time since touchdown, up to the longest dwell time of the sets.
Panel time_panel(const Sets& sets, Quantity quantity);

/// Figures 4–9, 10–14 and 15–17.
std::vector<Figure> differentiation_figures(const Sets& sets);
std::vector<Figure> integration_figures(const Sets& sets);
std::vector<Figure> comparison_figures(const ThesisInputs& inputs, const Sets& sets);

}  // namespace strobe::report
