// The path of the ball on a photograph, seen from the surface: what the matching of images to flashes works
// on. Plain values and a pure function; thread-safe.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/flight/aerodynamics.hpp"
#include "common/reduction/frame.hpp"
#include "common/shot/leg.hpp"

namespace strobe::matching {

/// Flashes between two images of a leg whose image was not found: two happen, three do not.
inline constexpr int kMaxMissed = 2;

/// In place of a flash's number: no flash made the image.
inline constexpr int kNoFlash = -1;

struct TrackPoint {
  Leg leg = Leg::contact;
  /// In the surface's axes: along it in the direction of travel, up from it. [px of the photograph]
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double variance_share = 1.0;  ///< variance of each coordinate over Track::sd_px squared; > 0
  double probability = 1.0;     ///< that it is an image of the ball: BallImage::probability; above 0
};

/// Shortest and longest contact of a ball with a surface; tennis balls take 3.8 to 6.3 ms.
inline constexpr double kShortestDwell_s = 1.5e-3;
inline constexpr double kLongestDwell_s = 9e-3;

struct DwellLimits {
  double least_s = kShortestDwell_s;
  double most_s = kLongestDwell_s;

  /// As far about another kind of ball's usual contact as those are about a tennis ball's.
  static DwellLimits about(double usual_s) { return {0.3 * usual_s, 1.8 * usual_s}; }

  /// Of a ball of which the size alone is known: hard balls of other sizes than a tennis ball's take less
  /// than a millisecond, hollow ones as much longer as they are larger, basketballs some 15 ms.
  static constexpr DwellLimits of_diameter(double diameter_m) {
    constexpr double kTennis_m = 0.067;
    const bool tennis = diameter_m > 0.060 && diameter_m < 0.070;
    return {tennis ? kShortestDwell_s : 0.3e-3,
            kLongestDwell_s * (diameter_m > kTennis_m ? diameter_m / kTennis_m : 1.0)};
  }
};

struct Track {
  std::vector<TrackPoint> images;  ///< in the frame's order: incoming, contact, rebound
  double radius_px = 0.0;          ///< of the undeformed ball
  bool surface_known = true;       ///< else nothing is known of where the legs end, nor of the contact
  double px_per_m = 0.0;
  double sd_px = 0.0;  ///< of each coordinate; as stated, else 0.8 % of the diameter
  Eigen::Vector2d gravity_pxps2 = Eigen::Vector2d::Zero();
  flight::Aerodynamics air{.drag_per_m = 0.0, .lift_per_m = 0.0};  ///< of the ball
  double missed_share = 0.005;   ///< of the ball's images that are not found
  int most_missed = kMaxMissed;  ///< of a leg, and between both
  double time_sd_s = 0.0;        ///< of a flash's time
  DwellLimits dwell{};
};

/// Whether both legs lie on one line across the surface, where their images hide each other: of those fewer
/// are found than elsewhere, and the track then allows for it.
bool allow_for_drop(Track& track);

/// A person who marks a centre by hand errs by about 0.5 mm in each coordinate, as a share of a ball's
/// diameter.
inline constexpr double kHandSdOfDiameter = 0.008;

/// The images' centres in the surface's axes, with their scale, noise and legs, of a frame whose images have
/// no times yet. A leg that the frame names is kept unless the centre is clearly less than a radius above the
/// surface; the others are classified. Air and flashes are not looked at. Returns nullopt without a surface
/// line or any diameter.
std::optional<Track> image_track(const reduction::Frame& frame);

}  // namespace strobe::matching
