// Decides which of the directions found by the search is the equator line of a ball, if any. Thread-safe;
// allocates.
#pragma once

#include <optional>

#include "host/digitize/core/types.hpp"
#include "host/digitize/equator/line_fit.hpp"
#include "host/digitize/equator/line_search.hpp"

namespace strobe::digitize {

inline constexpr double kMaxTilt_rad = 1.25;  ///< beyond, a line runs along the outline

/// The line as most balls of the photograph show it.
struct TypicalLine {
  double contrast = 0.0;
  double spread = 0.0;  ///< LineShape::spread(), radii
};

/// Within the accuracy of single fits.
bool is_typical(const EquatorLine& line, const TypicalLine& typical);

struct LineChoice {
  bool accepted = false;
  std::optional<LineFit> fit;  ///< of the most likely line, accepted or not
  double score = 0.0;          ///< of its peak
  Rejection why{Reason::at_border, "outside of the photograph"};
};

/// Settings of fit_line() for a line of about that tilt on that disc. shapes: see LineFitSettings.
LineFitSettings line_fit_settings(const Disc& disc, TiltRange range, double tilt_rad,
                                  const ShapeGrid* shapes);

/// Why a fitted line is rejected. Returns nullopt if it passes. `typical`: it is known to look like most
/// balls' lines, and the limits are lower.
std::optional<Rejection> check_line(const LineFit& fit, bool typical);

/// Without the typical line, accepts only what stands out from any seam, print or felt; with it, also what
/// looks like it and has no rival that does.
/// `range`: of the search.
LineChoice choose_line(BallPixels& pixels, const LineSearch& search, const ShapeGrid& shapes, TiltRange range,
                       const std::optional<TypicalLine>& typical);

}  // namespace strobe::digitize
