// How well the digitizer will measure an image of the ball, before there is a photograph: standard deviations
// of total error about the truth, and how likely it is that an image is measured at all. Power laws and
// logistic curves of the conditions, fitted to the errors of host/digitize (standard effort) on photographs
// that sim/photograph rendered, with looks of ball, lamps and background drawn anew for each (`strobe-bench
// digitizer-noise`). Outside of the conditions that were measured: not known. Pure; thread-safe; allocates
// not.
#pragma once

#include <optional>

#include "host/design/overlap.hpp"

namespace strobe::host {

/// What the fit is of; more or less is not known.
struct ConditionRange {
  double least = 0.0, most = 0.0;
  bool contains(double value) const { return least <= value && value <= most; }
};
inline constexpr ConditionRange kBallDiameter_px{40.0, 450.0};
inline constexpr ConditionRange kBlur_px{0.4, 3.0};
inline constexpr ConditionRange kMotion_px{0.0, 3.0};
inline constexpr ConditionRange kExposure{0.125, 2.0};
inline constexpr ConditionRange kFullWell_e{3e3, 60e3};
inline constexpr ConditionRange kReadNoise_e{3.0, 30.0};
inline constexpr ConditionRange kLineContrast{0.2, 1.0};
inline constexpr ConditionRange kLineWidth{0.0227, 0.0607};  ///< over the diameter
inline constexpr ConditionRange kReadableShare{0.2, 1.0};    ///< of the outline

/// One image of the ball.
struct PictureConditions {
  double ball_diameter_px = 0.0;
  double blur_px = 0.8;       ///< sd of the lens's blur
  double motion_px = 0.0;     ///< way of the ball during one flash; within the range it makes no difference
  double exposure = 1.0;      ///< at 1 the lightest felt of one image has a light of .45 of what saturates
  double full_well_e = 15e3;  ///< of it and of the next: likewise
  double read_noise_e = 8.0;
  double line_contrast = 0.75;  ///< of the equator line: darkness over the felt's
  double line_width = 0.042;    ///< over the diameter
  Overlap overlap;              ///< by all other images, those in contact included
};

/// The share of an outline that tells where it is: all that is free, and of what lies within other images'
/// discs a part, as long as the light there does not saturate.
double readable_share(const Overlap& overlap, double exposure);

/// Independent from image to image where nothing else is said.
struct DigitizerSds {
  double centre_along_px = 0.0;   ///< along the ball's path
  double centre_across_px = 0.0;  ///< across it
  double centre_common_px = 0.0;  ///< each coordinate: what all images of a leg are off alike
  double diameter_px = 0.0;
  double diameter_common_px = 0.0;  ///< what all images of the photograph are off alike
  double equator_rad = 0.0;
  double equator_common_rad = 0.0;  ///< what all images of a leg are off alike
  /// Across the surface, of each of kSurfacePoints evenly spread independent points of its line, seen from
  /// the balls: what the lowest points of all of them are off alike is in it.
  double surface_px = 0.0;
  double found = 0.0;          ///< probability that the image is measured
  double equator_found = 0.0;  ///< that its equator is, if the image is

  /// Each coordinate.
  double centre_px() const;
};
inline constexpr int kSurfacePoints = 4;

/// Returns nullopt outside of the ranges above.
std::optional<DigitizerSds> digitizer_sds(const PictureConditions& conditions);

}  // namespace strobe::host
