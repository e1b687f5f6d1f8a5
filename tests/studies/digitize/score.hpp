// A digitized photograph held against the truth: which images were found, which invented, and the errors of
// what was measured, in px and in units of the stated standard deviations. Deterministic; no I/O;
// thread-safe.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/reduction/frame.hpp"

namespace strobe::studies::digitize {

/// One image of the ball as it truly is on the photograph, in the frame's px.
struct TrueImage {
  reduction::Leg leg = reduction::Leg::incoming;
  reduction::PointPx centre_px;
  double diameter_px = 0.0;
  std::optional<double> equator_rad;
  std::optional<double> equator_tilt_rad;  ///< of that direction, as in reduction::BallImage
  std::optional<reduction::PointPx> top_px;
  std::optional<double> contact_width_px;
  bool whole = true;  ///< not cut off by the border
};

/// An error of this many stated sds is wrong and was not said to be.
inline constexpr double kWild_sd = 5.0;

/// A place of the frame at which the digitizer said that there is something it could not measure.
struct ReportedPlace {
  reduction::PointPx at_px;
  std::string what;  ///< "image", "equator" ...
};

/// Sums of squares of errors, and of errors over their stated sd.
struct ErrorTally {
  int count = 0;
  double squares = 0.0, sum = 0.0, largest = 0.0;
  int stated = 0;
  double normalized_squares = 0.0;
  int wild = 0;  ///< of the stated ones, those beyond kWild_sd

  void add(double error, std::optional<double> sd);
  void add(const ErrorTally& other);
  double rms() const;         ///< NaN if nothing was counted
  double bias() const;        ///< mean error
  double normalized() const;  ///< rms of error/sd; NaN if none was stated
};

struct Score {
  int airborne = 0;  ///< whole airborne images there are
  int found = 0;     ///< of those
  int reported = 0;  ///< of those not found, where something was said to be that could not be measured
  int contact = 0, contact_found = 0;
  int cut = 0;  ///< cut off by the border; neither missed nor invented
  int invented = 0;
  int lines = 0;  ///< of the found airborne images, those with a line that shows
  int lines_found = 0;
  int lines_reported = 0;  ///< of those not found, said to be unmeasured
  int lines_invented = 0;  ///< of the found airborne images without a line, those of which one was told
  ErrorTally x_px, y_px;   ///< of the found airborne images
  ErrorTally mahalanobis;  ///< of the centre: its normalized squares are halved, so that 1 is true
  ErrorTally diameter_px;
  ErrorTally equator_rad;
  ErrorTally tilt_rad;  ///< of the line: positive is away from the diameter
  ErrorTally top_px;  ///< of contact images, height only
  ErrorTally contact_width_px;
  ErrorTally surface_px;  ///< height of its line in the middle of the frame's points, seen from the balls

  void add(const Score& other);
  /// Centres, diameters, equators and surfaces beyond kWild_sd.
  int wild() const { return mahalanobis.wild + diameter_px.wild + equator_rad.wild + surface_px.wild; }
};

/// A true image and the frame's image that was taken of it.
struct Pair {
  std::size_t truth = 0, image = 0;
  double distance_px = 0.0;
};

/// Each of either once, the nearest first.
std::vector<Pair> pairs_of(const std::vector<TrueImage>& truth,
                           const std::vector<reduction::BallImage>& images);

/// An image is found if one of the frame's has its centre within a tenth of the diameter of the true one (a
/// contact image: a quarter, as its outline is not round); each of the frame's images counts once.
Score score(const std::vector<TrueImage>& truth, const reduction::Frame& frame,
            const std::vector<ReportedPlace>& reported = {});

/// The frame's surface against the true line through two points, seen from the lowest points of the balls
/// that `score` has of this one photograph: what they are off alike heights are, too. Its sd is that of the
/// mean of independent points, as the reduction takes them.
void score_surface(const std::vector<reduction::PointPx>& line, const reduction::Frame& frame, Score& score);

/// Times of found images that are not as far from the others' as they truly are, by more than a millisecond:
/// taken for another flash's. Which flash was the first cannot be seen on images at even intervals, so that
/// all may be off by the same time: the middle one of the differences is left out. `times_s`: of `truth`.
struct TimeCount {
  int measured = 0, wrong = 0;
  void add(const TimeCount& other);
};
TimeCount count_times(const std::vector<TrueImage>& truth, const std::vector<double>& times_s,
                      const reduction::Frame& frame);

}  // namespace strobe::studies::digitize
