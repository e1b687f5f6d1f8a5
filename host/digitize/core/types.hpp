// What the stages of the digitizer hand to each other. Coordinates: image px (photograph.hpp) where a name
// says image, else plane px (plane_map.hpp). Plain values.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace strobe::digitize {

/// How much time is spent: fast, standard, or thorough: outlines measured several times over.
enum class Effort { fast, standard, thorough };

std::string_view name(Effort effort);
std::optional<Effort> effort_from_name(std::string_view name);

/// Why something that looked like an image of the ball, or a part of it, was not measured. A closed list.
enum class Reason {
  few_edges,   ///< too little of its outline is seen
  wrong_size,  ///< not the ball's size
  not_round,   ///< the outline is no ellipse that a ball can have
  off_path,    ///< not on the ball's path
  at_border,   ///< cut off by the photograph's border
  saturated,   ///< too bright to tell
  duplicate,   ///< another candidate fits the same outline better
  below_surface,
  no_line,         ///< no equator line is seen
  line_ambiguous,  ///< two lines are as likely
  no_plate,        ///< no surface line is seen
  imprecise,       ///< the standard deviation would be beyond use
  by_hand,         ///< a person removed it
};

std::string_view name(Reason reason);

struct Rejection {
  Reason reason = Reason::few_edges;
  std::string detail;  ///< for a person, with numbers: "outline seen over 41 of 360 degrees"
};

template <typename T>
using Measured = tl::expected<T, Rejection>;

/// A place where an outline of the ball's size may be.
struct Candidate {
  cv::Point2d centre_image;
  double radius_image_px = 0.0;
  double score = 0.0;  ///< share of the outline that votes for it, 0 to 1
};

/// A stretch of an outline that was seen, counter-clockwise from `from_rad`, directions in plane px from the
/// centre.
struct Arc {
  double from_rad = 0.0;
  double extent_rad = 0.0;  ///< > 0
};

/// A round outline.
struct Outline {
  cv::Point2d centre;
  double diameter = 0.0;          ///< of the disc of equal area
  cv::Matx33d covariance;         ///< of centre x, centre y, diameter [px²]
  std::vector<Arc> seen;          ///< what it was fitted to
  double visible_fraction = 0.0;  ///< of the whole turn, 0 to 1
  double rms_px = 0.0;            ///< of the edge points about it
  double blur_px = 0.0;           ///< sd of the edge's blur

  /// Of the centre's less well known coordinate. [px]
  double centre_sd() const { return std::sqrt(std::max(covariance(0, 0), covariance(1, 1))); }
  double diameter_sd() const { return std::sqrt(std::max(0.0, covariance(2, 2))); }
};

/// The ball's diameter line.
struct Equator {
  double angle_rad = 0.0;  ///< counter-clockwise from +x, 0 to pi
  double sd_rad = 0.0;
  double contrast = 0.0;  ///< darkness of the line over the ball's brightness around it, 0 to 1
};

}  // namespace strobe::digitize
