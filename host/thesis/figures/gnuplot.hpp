// Figures to files through gnuplot: for each the data (.csv), the script (.gp) and what it draws (.svg,
// .png). The text functions are pure; draw() writes files and runs gnuplot; single-threaded.
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

/// Draws into a temporary folder and moves the four files into `folder` (created if missing) once all are
/// complete.
Result<void> draw(const Figure& figure, const std::filesystem::path& folder,
                  const std::filesystem::path& gnuplot);

}  // namespace strobe::report
