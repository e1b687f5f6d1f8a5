// The measured accuracy-cost frontier of the methods, and the choice of one by a tolerance and a deadline.
// The files are share/strobe/frontier/frontier.csv and ranges.csv (described by the README.md beside them),
// written by `strobe-bench trade`. Pure functions; deterministic; thread-safe; they allocate, so not for the
// real-time path.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::frontier {

/// One method of one study.
struct Row {
  std::string study;      ///< the quantity computed: "lift_off", "reduce"
  std::string method;     ///< "ode"
  std::string parameter;  ///< "tolerance=1e-09", several joined by ';', or empty
  double cost_us = 0.0;   ///< microseconds a call on the machine that measured, > 0
  double error = 0.0;     ///< bound or rms of the study, in `error_unit`, >= 0
  std::string error_unit;
  std::string note;
  bool operator==(const Row&) const = default;
};

/// Range of one quantity over the scenes of a study.
struct Range {
  std::string study;
  std::string quantity;  ///< "vx_mps"
  double lowest = 0.0;
  double highest = 0.0;  ///< >= lowest
  bool operator==(const Range&) const = default;
};

/// Parses rows below the header study,method,parameter,cost_us,error,error_unit,note, in the file's order.
/// Fails, as "SOURCE:LINE: column: what is wrong", on another header, a missing name, unprintable characters,
/// a cost that is not above 0, an error below 0, a method twice with the same parameter, a second unit in a
/// study.
Result<std::vector<Row>> parse_frontier(std::string_view text, std::string_view source);

/// Parses rows below the header study,quantity,lowest,highest. Fails likewise, and where lowest is above
/// highest.
Result<std::vector<Range>> parse_ranges(std::string_view text, std::string_view source);

/// The rows of a study, in their order.
std::vector<Row> of_study(std::span<const Row> rows, std::string_view study);

/// The value of NAME in "NAME=VALUE;OTHER=VALUE", as a view into the parameter. Returns nullopt if it is not
/// there.
std::optional<std::string_view> parameter_value(std::string_view parameter, std::string_view name);

/// A limit that is absent does not apply.
struct Requirement {
  std::optional<double> tolerance;    ///< largest error, in the rows' unit
  std::optional<double> deadline_us;  ///< longest time

  bool meets_tolerance(const Row& row) const { return !tolerance || row.error <= *tolerance; }
  bool meets_deadline(const Row& row) const { return !deadline_us || row.cost_us <= *deadline_us; }
  bool is_met_by(const Row& row) const { return meets_tolerance(row) && meets_deadline(row); }
};

/// The rows nearest to a requirement that none meets. The first two are absent where no row meets that limit
/// alone, the others where there are no rows.
struct NearestMethods {
  std::optional<Row> most_accurate_in_time;
  std::optional<Row> fastest_accurate_enough;
  std::optional<Row> fastest;
  std::optional<Row> most_accurate;
};

/// With a tolerance the cheapest row that meets the requirement, else the most accurate one; ties by the
/// other criterion, then by order. The result is on the Pareto frontier. Fails if no row meets the
/// requirement. Precondition: all rows of one study and unit.
tl::expected<Row, NearestMethods> choose(std::span<const Row> rows, const Requirement& requirement);

/// "ode tolerance=1e-09"
std::string label(const Row& row);

/// "0.01% of v_td in 12 us"
std::string accuracy_and_cost(const Row& row);

/// "0.1% and 50 us"
std::string requirement_text(const Requirement& requirement);

/// The reason of choose()'s choice, as part of a sentence: "the cheapest of 9 methods that meets 0.1% and 50
/// us".
std::string reason(std::span<const Row> rows, const Requirement& requirement);

/// The error of choose() as a sentence: "no method meets 0.1% and 5 us; in time the most exact is grip (4% of
/// v_td in 0.02 us), exact enough the fastest is ode tolerance=0.001 (0.04% of v_td in 9 us)".
std::string failure_text(const NearestMethods& nearest, const Requirement& requirement);

struct Quantity {
  std::string_view name;
  double value = 0.0;
};

/// Names of the quantities outside of the ranges of a study's scenes; quantities without a range are ignored.
std::vector<std::string> outside(std::span<const Range> ranges, std::string_view study,
                                 std::span<const Quantity> quantities);

}  // namespace strobe::frontier
