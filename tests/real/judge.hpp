// What a program has found on a photograph, held against the truth. Pure; thread-safe; allocates.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/real/collection.hpp"

namespace strobe::real {

/// A found image belongs to the ball that is nearest in its diameters, up to this; one image to one ball.
inline constexpr double kReach = 0.25;
/// A second image of a ball has its centre within the ball.
inline constexpr double kInside = 0.5;

/// An image of a ball as a program found it, with what it may say of how sure that is.
struct Found : Circle {
  struct Sds {
    double x = 0.0, y = 0.0, d = 0.0;  ///< px, above 0
  };
  std::optional<Sds> sds = std::nullopt;
};

/// An error, and the sd that was stated for it. [px]
struct Deviation {
  double error = 0.0, sd = 0.0;
};

/// An image that belongs to no ball.
struct Stray : Circle {
  const char* what = "";  ///< "invented", "ghost" or "double"
};

/// Counts and errors; of several photographs they add up.
struct Score {
  int pictures = 0;
  int balls = 0;                               ///< that must be found
  int found = 0;                               ///< of these
  int invented = 0;                            ///< where nothing is annotated
  int ghosts = 0;                              ///< ghosts taken for balls
  int doubles = 0;                             ///< second images of a ball
  std::vector<double> centre_px, diameter_px;  ///< errors of those found: distance; measured less annotated
  std::vector<Deviation> place, size;          ///< of those found with sds: in x and in y; of the diameter
  std::vector<Ball> missed;
  std::vector<Stray> strays;
  std::set<std::string> names;        ///< of those found: "photograph place"
  std::set<std::string> asked_names;  ///< of those that must be found

  Score& operator+=(const Score& other);
  double recall() const { return balls ? static_cast<double>(found) / balls : 1.0; }
  /// Harmonic mean of recall and precision; ghosts are left out, since not every collection annotates them.
  double f1() const { return 2.0 * found / std::max(1, balls + found + invented + doubles); }
};

/// told: the scale that the program was told, over the photograph's own. Balls whose size is further than
/// `tolerance` (a share) from what was told count neither way. per_px: errors are in so many pixels (of a
/// photograph that was made smaller, its factor).
Score judged(const Photograph& photograph, const std::vector<Found>& found, double told = 1.0,
             double tolerance = 1e9, double per_px = 1.0);

/// One by one: places in `ones` and `others`, nearest first, none twice.
std::vector<std::pair<std::size_t, std::size_t>> matched(const std::vector<Ball>& ones,
                                                         const std::vector<Circle>& others);

/// Of a ball, or of balls, in place i of both: found under one of two circumstances and not under the other,
/// of those that had to be found in both.
std::size_t changed(const Score& one, const Score& other);

/// Root mean square; NaN of nothing.
double rms(const std::vector<double>& values);

/// How far apart two annotations of the same photographs are.
struct Agreement {
  std::vector<double> centre_px, diameter_px;  ///< differences: distance; second less first
  int only_one = 0;  ///< balls that one annotator has as such and the other not at all
  /// Between the two; one by itself is as far from the truth as that over the root of 2.
  double centre_rms_px() const { return rms(centre_px); }
  double diameter_rms_px() const { return rms(diameter_px); }
};

/// How many errors are beyond three of their sds, an annotation's own noise (of each coordinate; of the
/// diameter) taken into them; of how many that are stated. Normal errors are in 0.27 %.
struct Beyond {
  int count = 0, of = 0;
};
Beyond beyond_3_sd(const Score& score, const Agreement& annotators);

/// Of the balls (Kind::ball by either) in those photographs that were annotated twice.
Agreement agreement(const std::vector<Photograph>& photographs);

}  // namespace strobe::real
