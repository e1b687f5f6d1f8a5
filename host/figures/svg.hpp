// Figures drawn as SVG, and written to files with the numbers that they show. The same figure gives the same
// bytes. Pure but for write_figure(); thread-safe; allocates.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/figures/figure.hpp"

namespace strobe::figures {

/// A drawing for each row of panels, the legend in the last, to stand within HTML, which has title and
/// caption: no script, no style of its own, nothing loaded.
std::vector<std::string> svg_rows(const Chart& chart);

/// A ball with its spin, and lines of words beside it, the first in bold.
struct SpinningBall {
  std::array<double, 3> spin{};  ///< right-handed, any unit: x right, y up, z towards whoever looks
  std::vector<std::string> lines{};
};

/// One drawing of all, two in a row: the spin's axis as an arrow, its hidden part dashed; at the pole that is
/// seen a dot where the arrow comes out, a cross where it goes in; and the way that the great circle about it
/// turns.
std::string balls_svg(const std::string& title, const std::vector<SpinningBall>& balls);

/// Columns series,x,y,low,high; series apart by two blank lines, numbers shortest-round-trip, no value where
/// there is none.
std::string csv_text(const Figure& figure);

/// `stem`.csv and, as a drawing that stands alone with title and caption, `stem`.svg in `folder`, which is
/// made if it is missing. x_names: as of make_chart(). Fails with the name of a file or folder that cannot be
/// made or written.
Result<void> write_figure(const Figure& figure, const std::filesystem::path& folder, const std::string& stem,
                          const std::vector<std::string>& x_names = {});

}  // namespace strobe::figures
