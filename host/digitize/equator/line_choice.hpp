// Which of the directions that a search brought up is the line on a ball, if any is. Thread-safe; allocates.
#pragma once

#include <optional>
#include <span>

#include "host/digitize/equator/line_fit.hpp"
#include "host/digitize/equator/line_search.hpp"

namespace strobe::digitize {

/// The line as most balls of the photograph show it.
struct TypicalLine {
  double contrast = 0.0;
  double spread = 0.0;  ///< of its shape, radii
};

/// As nearly as fits to single balls allow.
bool is_typical(const EquatorLine& line, const TypicalLine& usual);

/// What is known of one ball's line.
struct LineChoice {
  bool accepted = false;
  std::optional<LineFit> fit;  ///< of the likeliest line, also where it was not accepted
  double score = 0.0;          ///< of its peak
  Rejection why{Reason::at_border, "outside of the photograph"};
};

/// Settings for fit_line() on that disc; without shapes, the start's is kept.
LineFitSettings fit_settings(const Disc& disc, const ShapeGrid* shapes);

/// Why a fitted line is none; absent: nothing speaks against it. `usual`: it is known to be as most balls
/// show it.
std::optional<Rejection> find_fault(const LineFit& fit, bool usual);

/// Without the usual line, only what stands out from anything that seams, print and felt bring about is
/// accepted; with it, what is like it and has no rival that is.
LineChoice choose_line(BallPixels& rows, const LineSearch& search, const ShapeGrid& shapes,
                       const std::optional<TypicalLine>& usual);

}  // namespace strobe::digitize
