// How well the digitizer will measure an image of the ball, before there is a photograph: standard deviations
// of its errors about the truth, and how likely it is that an image is measured at all. Power laws and
// logistic curves of the conditions, fitted to the errors of host/digitize (standard effort) on photographs
// that sim/photograph rendered, with the looks of ball, lamps and background drawn anew for each
// (`strobe-bench digitizer-noise`). Outside of the conditions that were measured: not known. Pure;
// thread-safe; allocates nothing.
//
// Grain and hair of the felt decide, not the sensor: motion and noise within the ranges made no difference
// that could be told from none.
//
// What the digitizer needs: a ball of 40 px or more, and steps from image to image before the impact of .35
// of the diameter, where nine of ten images are measured; of .3 it is three of four, of .25 half, and
// photographs are lost as a whole. Where overlaps saturate (three images at an exposure of 1.2, two at 1.8)
// the outline that is free must do, and steps of .5 are needed. Blur of a twentieth of the diameter costs
// images, too.
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
inline constexpr double kMinStep = 0.25;

/// Light of the lightest felt in one image at an exposure of 1, over what saturates.
inline constexpr double kLightestFelt = 0.45;

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
  double step = 1.0;            ///< from image to image before the impact, over the diameter; for `found`
  Overlap overlap{};            ///< by all other images, those in contact included
};

/// The share of an outline that tells where it is: all that is free, and of what lies within other images'
/// discs a part, as long as the light there does not saturate.
double readable_share(const Overlap& overlap, double exposure);

/// Each image's own error where nothing else is said. "Common" ones come on top. "Stated": what the
/// digitizer's covariance will say, which holds part of the common ones; the reduction weighs with it.
struct DigitizerSds {
  double centre_along_px = 0.0;   ///< along the ball's path
  double centre_across_px = 0.0;  ///< across it
  double centre_common_px = 0.0;  ///< each coordinate, of all images of a leg alike
  double centre_stated_px = 0.0;  ///< each coordinate
  double diameter_px = 0.0;
  double diameter_common_px = 0.0;  ///< of all images of the photograph alike
  double diameter_stated_px = 0.0;
  double equator_rad = 0.0;
  double equator_common_rad = 0.0;  ///< of all images of a leg alike
  double equator_stated_rad = 0.0;
  /// Across the surface, of each of kSurfacePoints evenly spread independent points of its line, seen from
  /// the balls: what the lowest points of all of them are off alike is in it. Where the digitizer finds one
  /// edge of the plate: of a third of the photographs it could not tell two edges apart, and stated a sd of
  /// some .14 diameters.
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
