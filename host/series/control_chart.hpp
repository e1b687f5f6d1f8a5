// A control chart of one number that ought to stay as it is: a two-sided tabular CUSUM of normal scores. The
// mean that it is held against is learnt on the way, and how much it scatters; what was known of the mean
// before counts as a measurement before the first. Deterministic; not thread-safe; allocates.
// Sources: E. S. Page, Continuous inspection schemes, Biometrika 41 (1954); D. M. Hawkins, Self-starting
// CUSUM charts for location and scale, The Statistician 36 (1987); D. Brook, D. A. Evans, An approach to the
// probability distribution of CUSUM run length, Biometrika 59 (1972).
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/reduction/witnesses.hpp"

namespace strobe::host {

/// What each score is drawn towards zero by, in sds: half the shift that is told soonest.
inline constexpr double kCusumAllowance = 0.5;

/// Mean number of scores until the two-sided CUSUM exceeds `decision_interval`, above 0, where they are
/// normal with sd 1 and the mean `shift`. By a Markov chain of 100 states a side.
double average_run_length(double decision_interval, double shift = 0.0);

/// Which decision interval has this average run length without a shift, 10 to 1e7. Some ten milliseconds.
double decision_interval(double run_length);

struct ChartPoint {
  std::size_t shot = 0;  ///< as given
  reduction::Estimate measured;
  /// Standard normal where nothing has changed: how far from the mean of those before. At most what the
  /// measurement's own sd says, so that one that scatters less than stated alarms less often. 0 of a first
  /// one without a reference, and of the second.
  double score = 0.0;
  double upper = 0.0, lower = 0.0;  ///< CUSUM of either side, both >= 0
};

/// What the chart began with, as far as it holds the change off: mean with its sd, and the factor to the
/// measurements' stated sds, 1 or more.
struct InControl {
  reduction::Estimate mean;
  double scatter_factor = 1.0;
};

class ControlChart {
 public:
  /// reference: what the number ought to be, with an sd > 0. Absent: what the first shots say.
  explicit ControlChart(double decision_interval, std::optional<reduction::Estimate> reference = {});

  /// The sd must be > 0. Once the chart has alarmed, the mean is learnt no further.
  const ChartPoint& add(std::size_t shot, const reduction::Estimate& measured);

  const std::vector<ChartPoint>& points() const { return points_; }
  double limit() const { return limit_; }
  /// Index of the point at which the chart alarmed first; nullopt: it did not.
  std::optional<std::size_t> alarm() const { return alarm_; }
  /// Of the alarm: index of the first point after the CUSUM's last zero, where the change began most likely.
  std::size_t since() const { return since_; }
  /// By the points before `end`. Returns nullopt if there are none and no reference.
  std::optional<InControl> in_control(std::size_t end) const;

 private:
  /// What the points so far say, in the stated sds.
  struct Learnt {
    double mean = 0.0, weight = 0.0;  ///< the inverse of the mean's variance; 0: nothing is known
    double sum_of_squares = 0.0;      ///< of standardized deviations from what was learnt before each
    double degrees_of_freedom = 0.0;
    bool has_reference = false;
    double score(const reduction::Estimate& measured) const;
    void learn(const reduction::Estimate& measured);
  };

  void judge(std::size_t index);

  double limit_ = 0.0;
  Learnt begin_, learnt_;
  std::vector<ChartPoint> points_;
  std::optional<std::size_t> alarm_;
  std::size_t since_ = 0, upper_since_ = 0, lower_since_ = 0;
};

}  // namespace strobe::host
