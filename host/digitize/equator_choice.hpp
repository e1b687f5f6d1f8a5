// Which of the directions that a search brought up is the line on a ball, if any is. Thread-safe; allocates.
#pragma once

#include <optional>
#include <span>

#include "host/digitize/equator_fit.hpp"
#include "host/digitize/equator_search.hpp"

namespace strobe::digitize {

/// The line as most balls of the photograph show it.
struct UsualLine {
  double contrast = 0.0;
  double spread = 0.0;  ///< of its shape, radii
};

/// As nearly as fits to single balls allow.
bool like_usual(const DiscLine& line, const UsualLine& usual);

/// What is known of one ball's line.
struct Choice {
  bool accepted = false;
  std::optional<LineFit> fit;  ///< of the likeliest line, also where it was not accepted
  double score = 0.0;          ///< of its peak
  Rejection why{Reason::at_border, "outside of the photograph"};
};

/// Settings for fit_line() on that disc; without shapes, the start's is kept.
FitSettings fit_settings(const Disc& disc, const ShapeTrials* shapes);

/// Why a fitted line is none; absent: nothing speaks against it. `usual`: it is known to be as most balls
/// show it.
std::optional<Rejection> fault(const LineFit& fit, bool usual);

/// Without the usual line, only what stands out from anything that seams, print and felt bring about is
/// accepted; with it, what is like it and has no rival that is.
Choice choose_line(BallRows& rows, const LineSearch& search, const ShapeTrials& shapes,
                   const std::optional<UsualLine>& usual);

}  // namespace strobe::digitize
