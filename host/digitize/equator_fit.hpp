// From a rough line to its angle: the line is cut into stretches, each says how far it is off to the side,
// and a straight line (or half an ellipse) is fitted to them robustly. What seams, print and neighbours do to
// some stretches is then an outlier, and how the rest scatters is the standard deviation, whatever the felt.
// Thread-safe; allocates.
#pragma once

#include <optional>
#include <vector>

#include "host/digitize/equator_shading.hpp"

namespace strobe::digitize {

/// One stretch of the line.
struct Stretch {
  double along = 0.0;     ///< u' of its middle, radii
  double off = 0.0;       ///< to the side of the fitted line, radii
  double weight = 0.0;    ///< inverse variance of `off` but for a factor common to all
  double dark = 0.0;      ///< contrast
  double dark_sd = 0.0;   ///< but for the same factor's root
  double standing = 1.0;  ///< 1 what fits, to 0 an outlier
};

struct LineFit {
  DiscLine line;
  std::vector<Stretch> stretches;
  double per_variance = 0.0;    ///< variance of the angle for a scatter of one, rad²
  double scatter = 0.0;         ///< variance of the stretches' offs times weight, that of M-estimation
  double inside_scatter = 0.0;  ///< the same as expected of what is within each stretch
  double freedom = 0.0;         ///< degrees of it
  double neighbours = 0.0;      ///< sum of the products of next stretches' offs, as `scatter`
  double dark_share = 0.0;      ///< of the stretches that could tell, those that are dark
  double steadiness = 0.0;      ///< how many sd the line is dark, by how the stretches' darkness differs
  double standing_share = 0.0;  ///< of the stretches, by weight, that fit
  double span = 0.0;            ///< between the outermost stretches, radii, at most 1.9
};

struct FitSettings {
  double offset_sd = 0.01;  ///< how far the line's middle may be from the disc's, radii
  double tilt_sd = 0.15;
  bool shape_known = false;  ///< then the start's shape is kept
};

/// Absent: too little is seen to fit anything.
std::optional<LineFit> fit_line(const Blocks& blocks, const Flattened& flattened, const Disc& disc,
                                const Shading& shading, const DiscLine& start, const FitSettings& settings);

}  // namespace strobe::digitize
