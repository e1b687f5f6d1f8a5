// A ball with dots at known places, and its attitude by them from one image. Axes of the picture: x right, y
// up, z towards the lens along the line of sight to the ball's centre, as if from far away (orthographic).
// Deterministic; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

struct DotPattern {
  std::vector<Eigen::Vector3d> dots;  ///< unit directions from the ball's centre, in the ball's axes
};

inline constexpr std::size_t kMinPatternDots = 4, kMaxPatternDots = 100;
inline constexpr double kMinDotsApart_rad = 0.1;
/// Of the radius: nearer to the middle no dot is lost towards the limb.
inline constexpr double kSurelySeen = 0.8;

/// A text of comma-separated values without a header, a dot a row: "x,y,z", a direction of length 1 to within
/// a hundredth, or "theta,phi" in degrees, the angle from +z (0 to 180) and that about it from +x (-360 to
/// 360); all rows alike. Lines that begin with # are remarks. Fails with "SOURCE:LINE: what is wrong" for
/// anything else, too few or many dots, and two nearer than kMinDotsApart_rad, which one image would show as
/// one.
Result<DotPattern> parse_dot_pattern(std::string_view text, std::string_view source);

/// A dark spot on the ball's disc, in radii from the disc's middle, u right and v up.
struct SeenDot {
  Eigen::Vector2d at;
  Eigen::Matrix2d covariance;  ///< of `at`, by the pixels' noise
  double darkness = 0.0;  ///< share of the ball's brightness that it takes in its middle, blurred as it is
};

/// What is darker than the ball's shading there and no larger than a dot can be, darkest first: dots, and
/// whatever else is on the ball. `outline` need not be of a ball with dots.
std::vector<SeenDot> find_dots(const Photograph& photograph, const PlaneMap& map, const Outline& outline);

struct BallAttitude {
  Eigen::Matrix3d attitude;  ///< from the ball's axes to the picture's
  /// Of the rotation vector, in the picture's axes, from the truth to `attitude`: dots, outline and pattern,
  /// times the reduced chi squared where that is above one.
  Eigen::Matrix3d covariance_rad2;
  int seen = 0, matched = 0;   ///< dark spots, and those that are the pattern's
  double rms_rad = 0.0;        ///< of the matched, as seen from the lens
  Eigen::Vector2d centre_off;  ///< by how much they say that the outline's centre is off, radii
};

struct DotMatchSettings {
  double pattern_sd_rad = 0.017;  ///< of a dot's place on the ball in either direction, > 0
  double centre_sd = 0.01;        ///< of the outline's centre in either direction, radii, > 0
  double radius_sd = 0.01;        ///< of the outline's radius, relative, > 0
};

/// The attitude that explains the seen dots: from pairs of dots as far apart as pairs of the pattern's, the
/// one that most others agree with, then least squares. Fails with one line where fewer than four dots agree,
/// or fewer than two thirds of those seen, or another attitude is not a thousand times less likely.
Result<BallAttitude> match_dots(const std::vector<SeenDot>& seen, const DotPattern& pattern,
                                const DotMatchSettings& settings);

/// The outline of the ball on a photograph of one, as the digitizer finds it. Fails with one line if it finds
/// none, or several.
Result<Outline> only_ball(const Photograph& photograph);

/// find_dots() and match_dots(), with the outline's own sds. Fails with "NAME: what".
Result<BallAttitude> measure_attitude(const Photograph& photograph, const PlaneMap& map,
                                      const Outline& outline, const DotPattern& pattern,
                                      double pattern_sd_rad);

}  // namespace strobe::digitize
