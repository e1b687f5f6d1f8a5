// A series that grows shot by shot, and what it says of each quantity, with what its uncertainty is made of.
// What all shots share (scale, ball, air, calibration) does not become smaller with their number: each shared
// source's effects are averaged with their signs, and sources are combined afterwards. Deterministic; not
// thread-safe; allocates. Source: JCGM 100:2008 (GUM), 4.2, 5.2 and F.1.2.
#pragma once

#include <array>
#include <compare>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/session/shot.hpp"

namespace strobe::host {

using reduction::EvaluationType;

/// One line of an uncertainty budget.
struct BudgetLine {
  std::string source;  ///< "centres", "scale", "ball diameter" ...
  EvaluationType type = EvaluationType::b;
  double input_sd = 0.0;   ///< of the source, in input_unit; 0 where it is made of many inputs
  std::string input_unit;  ///< "mm", "%", "" ...
  /// Of a source with one input: change of the quantity per input_unit, with its sign.
  std::optional<double> sensitivity;
  double effect = 0.0;                       ///< on the quantity, one standard deviation, >= 0
  double share = 0.0;                        ///< of the variance, 0 to 1
  std::optional<double> degrees_of_freedom;  ///< absent: infinitely many
  bool shared = false;                       ///< by all shots that have the same rig, ball and calibration
};

/// One quantity over a series.
struct QuantitySummary {
  int n = 0;
  double mean = 0.0;
  std::optional<double> scatter_sd;          ///< of the shots about their mean, n - 1; absent below two shots
  std::optional<double> standard_error;      ///< of the mean: scatter_sd / sqrt(n)
  double shared_sd = 0.0;                    ///< of the mean, from what the shots share
  bool shared_known = true;                  ///< false: a shot came without its budget, and there is no total
  std::optional<double> total_sd;            ///< of the mean: both
  std::optional<double> degrees_of_freedom;  ///< effective (Welch-Satterthwaite); absent: infinitely many
  /// Half width of the mean's 95 % interval; of a series that ended by what it said, that of sequential.hpp.
  std::optional<double> expanded_uncertainty;
  std::vector<BudgetLine> budget;  ///< of the mean
};

/// A shot that stands apart. It counts all the same: whoever knows why may leave it out by name.
struct SeriesOutlier {
  std::string shot;  ///< Shot::full_name()
  reduction::Quantity quantity = reduction::Quantity::theta_in_deg;
  double sds = 0.0;  ///< from the other shots' mean, in their scatter
};

/// Of counted shots that have a flag of the third dimension.
struct OutOfPlane {
  int shots = 0;
  double sum =
      0.0;  ///< of the spin axes' tilts [deg], or of the velocities to the camera [m/s], at touchdown
};

struct SeriesSummary {
  std::string name;  ///< "zero 23", or the session's
  int counted = 0;   ///< shots that count
  int rejected = 0;
  /// What `strobe fire --until-known` was asked for, where that decided how many shots there are; else empty.
  std::string until_known;
  std::array<QuantitySummary, reduction::kQuantityCount> quantities;  ///< index: Quantity
  std::vector<SeriesOutlier> outliers;
  OutOfPlane tilted, leaving;  ///< with axis_tilted; with out_of_plane
  /// What ran instead of the rig's loop, "kworker/1:2", where shots were aborted for lateness; in how many
  /// shots.
  std::map<std::string, int> culprits;
};

/// A source that shots share, told apart by whose it is.
struct SharedSource {
  reduction::Source source = reduction::Source::scale;
  int number = 0;        ///< BudgetSource::number
  std::string identity;  ///< of the calibration or the ball

  auto operator<=>(const SharedSource&) const = default;
};

/// Of a mean, one standard deviation of the source, with its sign.
struct SharedEffect {
  std::array<double, reduction::kQuantityCount> effect{};
  double input_sd = 0.0;
  std::string_view input_unit{};
};
using SharedEffects = std::map<SharedSource, SharedEffect>;

/// Keeps a few numbers of each shot.
class Series {
 public:
  /// A shot that is rejected is only counted as such, and what made it late is kept.
  void add(const Shot& shot);

  int counted() const { return counted_; }
  int rejected() const { return rejected_; }
  /// What a quantity's numbers are, in the order of the shots.
  const std::vector<double>& values(reduction::Quantity q) const { return of(q).values; }
  /// Of the mean of each quantity.
  SharedEffects shared_effects() const;
  SeriesSummary summary(std::string name) const;

 private:
  struct Column {
    std::vector<double> values;
    std::vector<std::size_t> shots;  ///< index in names_
  };

  const Column& of(reduction::Quantity q) const { return columns_[static_cast<std::size_t>(q)]; }
  void add_shared(const Shot& shot);
  void find_outliers(reduction::Quantity q, const QuantitySummary& s,
                     std::vector<SeriesOutlier>& found) const;

  int counted_ = 0, rejected_ = 0;
  std::map<std::string, int> culprits_;
  bool shared_known_ = true;  ///< every shot came with its budget
  std::vector<std::string> names_;
  std::array<Column, reduction::kQuantityCount> columns_;
  SharedEffects sums_;  ///< of the shots' effects
  std::string until_known_;
  OutOfPlane tilted_, leaving_;
};

SeriesSummary summarize(std::string name, std::span<const Shot> shots);

/// A shot stands apart where chance makes one as far off in 1 % of series (Grubbs's test, one quantity),
/// judged by the others' mean and scatter. Of fewer shots none is told. Two that stand apart together may
/// hide each other. Source: F. E. Grubbs, Procedures for detecting outlying observations in samples,
/// Technometrics 11 (1969).
inline constexpr double kOutlierLevel = 0.01;
inline constexpr int kMinForOutlier = 4;

/// One shot's budget of one quantity, line by line. Without lines that do nothing to the quantity; the map's
/// errors as one.
std::vector<BudgetLine> budget_lines(const reduction::Budget& budget, reduction::Quantity q);

// Limits of a run chart of single shots: an individuals chart.
// Source: W. A. Shewhart, Economic Control of Quality of Manufactured Product (1931); ISO 7870-2:2013,
// individuals and moving range.

/// Mean and three standard deviations either way, the sd from the mean range of two shots that follow each
/// other, so that a drift does not widen them.
struct IndividualsLimits {
  double mean = 0.0, lower = 0.0, upper = 0.0;
};

/// Mean range of two normal numbers over their standard deviation, 2/sqrt(pi).
inline constexpr double kRangeOfTwo = 1.1283791670955126;
/// Below, one range or two say next to nothing of the scatter.
inline constexpr std::size_t kMinForLimits = 4;

/// values: of the shots that count, in the order of firing. Absent below kMinForLimits.
std::optional<IndividualsLimits> individuals_limits(std::span<const double> values);

}  // namespace strobe::host
