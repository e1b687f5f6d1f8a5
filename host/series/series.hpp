// A series that grows shot by shot, and what it says: see series_summary.hpp. Keeps a few numbers of each shot.
// Deterministic; not thread-safe; allocates.
#pragma once

#include <array>
#include <compare>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "host/series/series_shot.hpp"
#include "host/series/series_summary.hpp"

namespace strobe::host {

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

class Series {
 public:
  /// A shot that is rejected is only counted as such.
  void add(const SeriesShot& shot);

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
  void add_shared(const SeriesShot& shot);
  void find_outliers(reduction::Quantity q, const QuantitySummary& s,
                     std::vector<SeriesOutlier>& found) const;

  int counted_ = 0, rejected_ = 0;
  bool shared_known_ = true;  ///< every shot came with its budget
  std::vector<std::string> names_;
  std::array<Column, reduction::kQuantityCount> columns_;
  SharedEffects sums_;  ///< of the shots' effects
};

SeriesSummary summarize(std::string name, std::span<const SeriesShot> shots);

/// A shot stands apart where chance makes one as far off in 1 % of series (Grubbs's test, one quantity), judged by the
/// others' mean and scatter. Of fewer shots none is told. Two that stand apart together may hide each other.
/// Source: F. E. Grubbs, Procedures for detecting outlying observations in samples, Technometrics 11 (1969).
inline constexpr double kOutlierLevel = 0.01;
inline constexpr int kMinForOutlier = 4;

}  // namespace strobe::host
