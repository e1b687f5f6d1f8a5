// What `strobe-bench trade` measures: for each study a list of methods with their cost and their error
// against a reference two orders better. Plain values; one thread's.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace strobe::studies::trade {

/// What an error comes from: a model that leaves out what the truth has, a method that solves the right
/// equations approximately, or noise of the measurement that any method suffers.
enum class Source { model, numerical, noise };

/// Over scenes. Where noise decides, a scene's error is the rms over its shots.
struct Error {
  double rms = 0.0, worst = 0.0;
};

/// Sums that an Error is made of.
class Tally {
 public:
  void add(double error) {
    square_ += error * error;
    // Keeps a NaN, so that it is seen.
    worst_ = std::isnan(error) || error > worst_ ? error : worst_;
    ++count_;
  }
  Error error() const { return {count_ > 0 ? std::sqrt(square_ / count_) : 0.0, worst_}; }

 private:
  double square_ = 0.0, worst_ = 0.0;
  int count_ = 0;
};

struct Row {
  std::string method;
  std::string parameter;  ///< "name=value", several joined by ';'; empty: none
  double cost_us = 0.0;   ///< a call, least of the repetitions
  Error practical{};      ///< over the seeded scenes of the practical range
  Error thesis{};         ///< over the thesis's 21 conditions
  Source source = Source::model;
  std::string remark{};
  bool general = false;  ///< of an engine that is not the product's
};

struct Study {
  std::string name, title;
  std::string what;        ///< scenes, norm of the error, reference: for the table's head
  std::string unit{};      ///< of the errors
  double reference = 0.0;  ///< error of the reference itself, same norm; 0: closed form in many digits
  bool drawn = true;       ///< has a panel in the figure
  std::vector<Row> rows{};
};

struct Effort {
  std::uint64_t seed = 1;
  int scenes = 200;      ///< of the practical range
  int shots = 2000;      ///< of each condition, for estimators
  int repetitions = 15;  ///< of every timing; the least counts
  bool quick = false;    ///< fewer tolerances and step counts
};

/// The error that a row stands for when methods are compared: of both sets of scenes the larger.
double error_of(const Row& row);

/// "method parameter"
std::string label(const Row& row);

struct Dominated {
  std::size_t by = 0;   ///< row
  double slower = 1.0;  ///< how many times
  double worse = 1.0;
};

/// For each row: the row that is neither slower nor less exact than it, but better in one; of several the one
/// that beats it most (product of both factors). None: the row is on the frontier. Costs within 5 % of each
/// other count as equal, since they are measured, and so do errors within 2 % where noise makes them.
std::vector<std::optional<Dominated>> dominated(const Study& study);

/// Rows of general engines that no row of the product's own is both as fast as (within 5 %) and as exact as,
/// `without` (a method) left out of the product's.
std::vector<std::size_t> beyond_own(const Study& study, const std::string& without = "");

/// What must hold of any run, as sentences about what does not: errors that fall with the tolerance down to
/// rounding, a reference better than every method, planned shots within their tolerance, finite figures.
std::vector<std::string> broken_invariants(const std::vector<Study>& studies);

}  // namespace strobe::studies::trade
