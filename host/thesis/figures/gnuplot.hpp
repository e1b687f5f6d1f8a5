// Figures to files through gnuplot: for each the data (.csv), the script (.gp) and what it draws (.svg,
// .png). The text functions are pure; draw() writes files and runs a program. One thread's.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"
#include "host/thesis/figures/plot.hpp"

namespace strobe::report {

/// "figure_04"
std::string file_stem(const Figure& figure);

/// Columns series,x,y,low,high; series apart by two blank lines (gnuplot's index), numbers
/// shortest-round-trip, no value where there is none.
std::string csv_text(const Figure& figure);

/// Reads <stem>.csv, writes <stem>.svg and <stem>.png, all in the working folder.
std::string script_text(const Figure& figure);

/// Path of gnuplot, searched in $PATH. Fails with one line that names the package to install.
Result<std::filesystem::path> find_gnuplot();

/// Draws into a new folder beside the files and moves them into `folder` (which it makes) when all four are
/// whole, so that none is ever half-written.
Result<void> draw(const Figure& figure, const std::filesystem::path& folder,
                  const std::filesystem::path& gnuplot);

}  // namespace strobe::report
