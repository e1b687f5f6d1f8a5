// What a series of shots says of each quantity, with what its uncertainty is made of. What all shots share (scale, ball,
// air, calibration) does not become smaller with their number: each shared source's effects are averaged with their signs,
// and sources are combined afterwards. Plain values; thread-safe.
// Source: JCGM 100:2008 (GUM), 4.2, 5.2 and F.1.2.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/reduction/uncertainty.hpp"
#include "common/reduction/readout.hpp"

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
  std::optional<double> expanded_uncertainty;  ///< half width of the mean's 95 % interval
  std::vector<BudgetLine> budget;              ///< of the mean
};

/// A shot that stands apart. It counts all the same: whoever knows why may leave it out by name.
struct SeriesOutlier {
  std::string shot;  ///< StoredShot::name
  reduction::Quantity quantity = reduction::Quantity::theta_in_deg;
  double sds = 0.0;  ///< from the other shots' mean, in their scatter
};

struct SeriesSummary {
  std::string name;  ///< "zero 23", or the session's
  int counted = 0;   ///< shots that count
  int rejected = 0;
  std::array<QuantitySummary, reduction::kQuantityCount> quantities;  ///< index: Quantity
  std::vector<SeriesOutlier> outliers;
};

}  // namespace strobe::host
