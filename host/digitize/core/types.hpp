// What the digitizer's stages pass to each other. Coordinates are image px (image/photograph.hpp) where a
// name says image, else plane px (plane_map.hpp). Plain values.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace strobe::digitize {

/// How much time is spent; thorough measures each outline several times.
enum class Effort { fast, standard, thorough };

std::string_view name(Effort effort);
std::optional<Effort> effort_from_name(std::string_view name);

/// Why a candidate became no image, or a part of an image was not measured. A closed list.
enum class Reason {
  few_edges,   ///< too little of its outline is visible
  wrong_size,  ///< not the ball's size
  not_round,   ///< the outline is no ellipse that a ball can have
  off_path,    ///< not on the ball's path
  at_border,   ///< cut off by the photograph's border
  saturated,
  ghost,      ///< a disc by ambient light between two flashes
  duplicate,  ///< another candidate fits the same outline better
  below_surface,
  no_line,         ///< no equator line is visible
  line_ambiguous,  ///< two lines are as likely
  no_plate,        ///< no surface line is visible
  imprecise,       ///< its standard deviation is too large
  by_hand,         ///< a person removed it
};

std::string_view name(Reason reason);

struct Rejection {
  Reason reason = Reason::few_edges;
  std::string detail;  ///< with numbers: "outline seen over 41 of 360 degrees"
};

template <typename T>
using Measured = tl::expected<T, Rejection>;

/// A candidate that became no image, or a part of an image that was not measured.
struct Unmeasured {
  cv::Point2d centre;  ///< plane px
  double diameter = 0.0;
  std::string what;  ///< "image", "equator", "top" ...
  Rejection why;
};

/// A possible outline of the ball's size.
struct Candidate {
  cv::Point2d centre_image;
  double radius_image_px = 0.0;
  double score = 0.0;  ///< share of the outline that edge points support, 0 to 1
  /// Of the best ones the radius, also beyond those sought, that edge points support best around this centre.
  double likeliest_radius_px = 0.0;
};

/// A visible part of an outline: directions from its centre in the plane, counter-clockwise from `from_rad`.
struct Arc {
  double from_rad = 0.0;
  double extent_rad = 0.0;  ///< > 0
};

/// A measured outline of the ball.
struct Outline {
  cv::Point2d centre;
  double diameter = 0.0;   ///< of the disc of equal area
  cv::Matx33d covariance;  ///< of centre x, centre y, diameter [px²]; symmetric, PSD
  /// Of the diameter, what all outlines of a photograph are off alike: in the covariance, too.
  double shared_diameter_sd_px = 0.0;
  std::vector<Arc> visible_arcs;  ///< what it was fitted to
  double visible_fraction = 0.0;  ///< of the whole circle, 0 to 1
  double rms_px = 0.0;            ///< of its edge residuals
  double blur_px = 0.0;           ///< sd of the edge's blur
  double rise = 0.0;              ///< of light over the limb, typically
  double probability = 1.0;       ///< that it is one of the ball's images, 0 to 1
  /// By which what lies under one side of it moves the outline there, rms, as far as its size tells. Paths
  /// allow for it as the most that it may be, and the covariance has it once the path is known.
  double moved_limb_px = 0.0;

  /// Half of a circle moved by x moves the fit's diameter by x, its centre by 2 x / pi towards there.
  double moved_centre_px() const { return 2.0 / std::numbers::pi * moved_limb_px; }
  /// Of the less certain coordinate. [px]
  double centre_sd() const { return std::sqrt(std::max(covariance(0, 0), covariance(1, 1))); }
  double diameter_sd() const { return std::sqrt(std::max(0.0, covariance(2, 2))); }
};

/// The line drawn around the ball's equator, seen as a diameter or half an ellipse, as in
/// reduction::BallImage.
struct Equator {
  double angle_rad = 0.0;  ///< of its ends, counter-clockwise from +x, 0 to pi
  double sd_rad = 0.0;
  struct Tilt {
    double tilt_rad =
        0.0;  ///< of its plane out of the line of sight: what is seen of it is left of angle_rad
    double sd_rad = 0.0;
    double correlation = 0.0;  ///< of angle and tilt
  };
  std::optional<Tilt> tilt;  ///< absent: too little of the line is seen
  double contrast = 0.0;     ///< share of the ball's brightness that the line takes, 0 to 1
};

}  // namespace strobe::digitize
