// From a coarse line to its angle and tilt: the half ellipse is cut into segments of one length, the offset
// of each is measured, and angle, tilt and the plane's offset are fitted to the offsets robustly. Seams,
// print and neighbours make outliers of some segments; where a neighbour's limb hides one edge of the line,
// the line's width and the neighbour's light are fitted too; the residuals of the others give the standard
// deviation, whatever the felt. What the outline leaves open of the ball's place and size counts in the
// variances: a tilted line shifts with them. Thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/digitize/equator/ball_pixels.hpp"

namespace strobe::digitize {

struct Segment {
  double along = 0.0;     ///< u' of its middle, radii: the sine of the angle from the line's middle
  double offset = 0.0;    ///< residual across the fitted line, radii
  double weight = 0.0;    ///< inverse variance of `offset`, up to a factor common to all
  double widening = 0.0;  ///< of `offset`, as the half width grows: 0 if both edges are seen, to 1 or -1
  double contrast = 0.0;
  double contrast_sd = 0.0;    ///< up to the same factor's root
  double inlier_weight = 1.0;  ///< 1 inlier, to 0 outlier
};

struct LineFit {
  EquatorLine line;
  std::vector<Segment> segments;
  cv::Matx33d prior;            ///< weights of the priors of angle, offset and tilt, for a scatter of one
  cv::Matx33d variance;         ///< of angle, offset and tilt, for a scatter of one, priors included
  double angle_variance = 0.0;  ///< as the segments' own residuals have it, neighbours' shared part included
  double scatter = 0.0;         ///< M-estimator's variance of the offsets times weight
  double expected_scatter = 0.0;       ///< the same from the residuals within the segments
  double degrees_of_freedom = 0.0;     ///< of `scatter`
  double covariance = 0.0;             ///< of adjacent segments' offsets, in the units of `scatter`
  double dark_fraction = 0.0;          ///< dark segments among those whose contrast is known well enough
  double contrast_significance = 0.0;  ///< z-score of the contrast, from its scatter over the segments
  double inlier_fraction = 0.0;        ///< of the segments, by weight
  double rms_offset = 0.0;             ///< of all segments, radii
  double span = 0.0;                   ///< between the outermost segments, radii, at most 1.9
};

struct LineFitSettings {
  double offset = 0.0;                ///< prior of the line's distance from the ball's middle, radii
  double offset_sd = 0.01;            ///< radii
  double tilt_sd = 0.15;              ///< prior about 0, rad
  double most_tilt_rad = 0.45;        ///< beyond, no line is fitted
  double centre_sd = 0.0;             ///< of the outline's middle, radii
  double radius_sd = 0.0;             ///< radii
  double blur = 0.0;                  ///< sd of the photograph's, radii
  const ShapeGrid* shapes = nullptr;  ///< null: the shape is not fitted
};

/// `radius`: the ball's in bins. Returns nullopt if too little is visible.
std::optional<LineFit> fit_line(std::span<const LinePoint> points, double radius, const EquatorLine& start,
                                const LineFitSettings& settings);

}  // namespace strobe::digitize
