// Figures 4 to 17: the images in contact and what the approaches make of them. The numbering follows the
// thesis's order of topics: differentiation (4–9), integration (10–14), the approaches beside each other (15,
// 16), touchdown to lift-off (17). Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/figures/figure.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::thesis {

inline constexpr int kFirstFigure = 4;
inline constexpr int kLastFigure = 17;

/// All of them for the sets given, overlaid or beside each other: the thesis's three (kMainSets), or one.
Result<std::vector<figures::Figure>> make_figures(const ThesisInputs& inputs,
                                                  const std::vector<std::string>& sets);

}  // namespace strobe::thesis
