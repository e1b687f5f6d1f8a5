// Figures drawn as SVG, and written to files with the numbers that they show. The same figure gives the same
// bytes. Pure but for write_figure(); thread-safe; allocates.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/figures/figure.hpp"

namespace strobe::figures {

/// A drawing for each row of panels, the legend in the last, to stand within HTML, which has title and
/// caption: no script, no style of its own, nothing loaded.
std::vector<std::string> svg_rows(const Chart& chart);

/// Columns series,x,y,low,high; series apart by two blank lines, numbers shortest-round-trip, no value where
/// there is none.
std::string csv_text(const Figure& figure);

/// `stem`.csv and, as a drawing that stands alone with title and caption, `stem`.svg in `folder`, which is
/// made if it is missing. x_names: as of make_chart(). Fails with the name of a file or folder that cannot be
/// made or written.
Result<void> write_figure(const Figure& figure, const std::filesystem::path& folder, const std::string& stem,
                          const std::vector<std::string>& x_names = {});

}  // namespace strobe::figures
