// Numbers with their uncertainty: a value and what each of its independent sources does to it, one standard
// deviation's, with sign. Whatever is computed of them keeps what they have in common, so that a difference
// or a ratio of numbers that share an error is as certain as it is. Part of the protocol's formulas, not of
// their interface. Not thread-safe per object; allocates. Source: JCGM 100:2008 (GUM), 5.1 and F.1.2; degrees
// of freedom: its G.4.1 (Welch-Satterthwaite).
//
// A mean over items (shots of a ball, balls, positions) takes each item for one of a sample: what no two
// items share is in their scatter already, and is replaced by it (type A, GUM 4.2.3), n - 1 degrees of
// freedom. The variance of the mean, s^2/n = sum d_i^2 / (n (n-1)) with the deviations d_i, is kept as one
// effect d_i / sqrt(n (n-1)) of each item: two means over the same items then have the covariance that the
// items' scatter has (GUM 5.2.3), and the difference or ratio of them is right. Balls that are used at
// several positions are the same items there. What items share (scale, map, ball's size, air, thermometer)
// does not become smaller: effects are averaged with their signs.
//
// Few items may scatter less by chance than each one's own sources say (the scatter of a ball's shots, the
// noise of a shot): then these are kept, and the scatter is not used. Otherwise tests whose balls happen to
// be alike would state too small a risk. Compare GUM H.5.2.5, which pools where the variance between is not
// the larger one.
//
// All others (spread, sd, min, max) are of just these items: their measurement errors alone make them
// uncertain.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/series/series.hpp"

namespace strobe::protocol {

struct Number {
  double value = 0.0;
  std::map<int, double> effects{};  ///< by the source's index in Sources
};

/// value: of a function of the arguments; each comes with the function's derivative by it.
Number function_of(double value, std::initializer_list<std::pair<const Number*, double>> arguments);

/// All that the numbers of one evaluation rest on.
class Sources {
 public:
  struct Source {
    std::string label;  ///< of its line in a budget; sources with the same label are one line
    host::EvaluationType type = host::EvaluationType::b;
    bool shared = false;    ///< never replaced by scatter: it may be common to shots that were not fired
    double input_sd = 0.0;  ///< with a line of its own
    std::string input_unit{};
    int group = -1;  ///< of sources that were estimated together; -1: infinitely many degrees of freedom
  };

  /// The index of the source that `identity` names; made of `source` if it is new.
  int find(const std::string& identity, const Source& source);
  /// Sources that were estimated together, by a name for them.
  int group(const std::string& identity, double degrees_of_freedom);

  double sd(const Number& number) const;
  /// Effective; absent: infinitely many.
  std::optional<double> degrees_of_freedom(const Number& number) const;
  /// Half width of the 95 % interval.
  double expanded(const Number& number) const;
  /// The largest first.
  std::vector<host::BudgetLine> budget(const Number& number) const;

  /// items: with a name that is theirs alone; at least one, of which alone the mean is itself. kind: "shots",
  /// "balls", "positions".
  Number mean(const std::string& kind, const std::vector<std::pair<std::string, Number>>& items);

 private:
  std::vector<Source> sources_;
  std::map<std::string, int> indices_, groups_;
  std::vector<double> freedoms_;
};

}  // namespace strobe::protocol
