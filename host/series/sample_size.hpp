// How many shots: for a mean's 95 % interval of a wanted half width, or to find a difference of a given size
// with a given power. The scatter of single shots is known, or measured from a few; what shots share does not
// become smaller with their number. Pure functions; thread-safe. Sources: Student's t with
// Welch-Satterthwaite's degrees of freedom (B. L. Welch, Biometrika 34, 1947; GUM G.4); power by the
// noncentral t (J. Cohen, Statistical Power Analysis, 1988, 2.3); the assured half width by chi-squared
// (F. A. Graybill, Ann. Math. Stat. 29, 1958).
#pragma once

#include <limits>
#include <optional>

namespace strobe::host {

/// Counted up to so many.
inline constexpr int kMaxShots = 1000000;
inline constexpr double kPower = 0.8;
inline constexpr double kMinPower = 0.5, kMaxPower = 0.999;

/// Of single shots about their mean.
struct Scatter {
  double sd = 0.0;  ///< >= 0
  double degrees_of_freedom =
      std::numeric_limits<double>::infinity();  ///< of its measurement; infinite: known
};

/// Shots, of each series where there are two, and the 95 % interval of that number where the scatter was
/// measured: a scatter of few shots may be far off.
struct ShotCount {
  int shots = 0, fewest = 0, most = 0;
};

/// Half width of the 95 % interval of a mean of n >= 2 shots; shared_sd: of the mean, what does not become
/// smaller.
double mean_half_width(double scatter_sd, double shared_sd, int n);

/// What half width is to be expected before n >= 2 shots are fired of which the scatter is known. assurance,
/// above 0 and below 1: the half width that is not exceeded with that probability; absent: the mean one.
double expected_half_width(double scatter_sd, double shared_sd, int n, std::optional<double> assurance = {});

/// The fewest shots, two or more, whose expected half width is at most half_width > 0. Absent: no number
/// would do, since what they share is too uncertain.
std::optional<ShotCount> shots_for_mean(const Scatter& scatter, double shared_sd, double half_width,
                                        std::optional<double> assurance = {});

/// What of the uncertainty of two means' difference shots can lessen, and what they cannot.
struct TwoMeans {
  double first_variance = 0.0, second_variance = 0.0;  ///< of one shot
  double shared_variance = 0.0;                        ///< of the difference

  double total_variance(double n1, double n2) const {
    return first_variance / n1 + second_variance / n2 + shared_variance;
  }
  /// Welch-Satterthwaite; infinite where nothing scatters.
  double degrees_of_freedom(double n1, double n2) const;
  /// Probability that a difference > 0 is found at the 5 % level by n1 and n2 shots; they may be infinite.
  double power(double difference, double n1, double n2) const;
};

/// Two series as they are to be fired.
struct TwoSeries {
  Scatter first, second;
  double shared_sd = 0.0;                 ///< of the difference of their means, what does not cancel
  int fired_first = 0, fired_second = 0;  ///< shots that there are
};

/// The fewest shots of each, no fewer than there are, by which a difference of that size is found at the 5 %
/// level with a probability of `power`, kMinPower to kMaxPower. Absent: no number would do, or difference is
/// not above 0.
std::optional<ShotCount> shots_for_difference(const TwoSeries& series, double difference,
                                              double power = kPower);

}  // namespace strobe::host
