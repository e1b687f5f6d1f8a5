// A digitized photograph held against the truth: which images were found, which invented, and the errors of
// what was measured, in px and in units of the stated standard deviations. Deterministic; no I/O;
// thread-safe.
#pragma once

#include <optional>
#include <vector>

#include "common/reduction/frame.hpp"

namespace strobe::bench::digitize {

/// One image of the ball as it truly is on the photograph, in the frame's px.
struct TrueImage {
  reduction::Leg leg = reduction::Leg::incoming;
  reduction::PointPx centre_px;
  double diameter_px = 0.0;
  std::optional<double> equator_rad;
  std::optional<reduction::PointPx> top_px;
  std::optional<double> contact_width_px;
  bool whole = true;  ///< not cut off by the border
};

/// Sums of squares of errors, and of errors over their stated sd.
struct ErrorTally {
  int count = 0;
  double squares = 0.0;
  double sum = 0.0;
  double largest = 0.0;
  int stated = 0;
  double normalized_squares = 0.0;

  void add(double error, std::optional<double> sd);
  void add(const ErrorTally& other);
  double rms() const;         ///< NaN if nothing was counted
  double bias() const;        ///< mean error
  double normalized() const;  ///< rms of error/sd; NaN if none was stated
};

struct Score {
  int airborne = 0;  ///< whole airborne images there are
  int found = 0;     ///< of those
  int contact = 0;
  int contact_found = 0;
  int cut = 0;  ///< cut off by the border; neither missed nor invented
  int invented = 0;
  int lines = 0;  ///< of the found airborne images, those with a line that shows
  int lines_found = 0;
  ErrorTally x_px, y_px;   ///< of the found airborne images
  ErrorTally mahalanobis;  ///< of the centre: its normalized squares are halved, so that 1 is true
  ErrorTally diameter_px;
  ErrorTally equator_rad;
  ErrorTally top_px;  ///< of contact images, height only
  ErrorTally contact_width_px;

  void add(const Score& other);
};

/// An image is found if one of the frame's has its centre within a tenth of the diameter of the true one (a
/// contact image: a quarter, as its outline is not round); each of the frame's images counts once.
Score score(const std::vector<TrueImage>& truth, const reduction::Frame& frame);

}  // namespace strobe::bench::digitize
