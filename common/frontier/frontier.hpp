// What methods cost and how exact they are, as measured, and the choice between them.
// The files are share/strobe/frontier/frontier.csv and ranges.csv (described by the README.md beside them),
// written by `strobe-bench trade`. Reading and choosing are pure functions of their arguments: deterministic,
// thread-safe; they allocate, so not for the real-time path.
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
  std::string study;      ///< what is asked for: "lift_off", "reduce"
  std::string method;     ///< "ode"
  std::string parameter;  ///< "tolerance=1e-09", several joined by ';', or empty
  double cost_us = 0.0;   ///< microseconds a call on the machine that measured, > 0
  double error = 0.0;     ///< what the method can be relied on for, in `error_unit`, >= 0
  std::string error_unit;
  std::string note;
  bool operator==(const Row&) const = default;
};

/// What the scenes of a study spanned in one quantity.
struct Range {
  std::string study;
  std::string quantity;  ///< "vx_mps"
  double lowest = 0.0;
  double highest = 0.0;  ///< >= lowest
  bool operator==(const Range&) const = default;
};

/// Rows below the header study,method,parameter,cost_us,error,error_unit,note, in the file's order. Refused,
/// as "SOURCE:LINE: column: what is wrong": another header, a missing name, unprintable characters, a cost
/// that is not above 0, an error below 0, a method twice with the same parameter, a second unit in a study.
Result<std::vector<Row>> parse_frontier(std::string_view text, std::string_view source);

/// Rows below the header study,quantity,lowest,highest. Refused likewise, and where lowest is above highest.
Result<std::vector<Range>> parse_ranges(std::string_view text, std::string_view source);

/// The rows of a study, in their order.
std::vector<Row> of_study(std::span<const Row> rows, std::string_view study);

/// The value of NAME in "NAME=VALUE;OTHER=VALUE", if it is there; a view into the parameter.
std::optional<std::string_view> parameter_value(std::string_view parameter, std::string_view name);

/// What is asked of a method. What is not stated asks nothing.
struct Demand {
  std::optional<double> tolerance;    ///< largest error, in the rows' unit
  std::optional<double> deadline_us;  ///< longest time

  bool exact_enough(const Row& row) const { return !tolerance || row.error <= *tolerance; }
  bool in_time(const Row& row) const { return !deadline_us || row.cost_us <= *deadline_us; }
  bool met_by(const Row& row) const { return exact_enough(row) && in_time(row); }
};

/// What comes nearest to a demand that no row meets.
struct Nearest {
  std::optional<Row> exactest_in_time;      ///< none: nothing is fast enough
  std::optional<Row> fastest_exact_enough;  ///< none: nothing is exact enough
  std::optional<Row> fastest;               ///< of all; none: there are no rows
  std::optional<Row> exactest;              ///< of all; none: there are no rows
};

/// The row to take: with a tolerance the cheapest that meets the demand, with a deadline alone (or no demand)
/// the most exact that meets it; of equals in that the better in the other, then the first. Never a row that
/// another is neither slower nor less exact than, and better in one. Refused iff no row meets both.
/// All rows of one study and unit.
tl::expected<Row, Nearest> choose(std::span<const Row> rows, const Demand& demand);

/// "ode tolerance=1e-09"
std::string title(const Row& row);

/// "0.01% of v_td in 12 us": what a row is relied on for.
std::string promise(const Row& row);

/// "0.1% and 50 us"
std::string demand_text(const Demand& demand);

/// Why choose() took it, as part of a sentence: "the cheapest of 9 methods that meets 0.1% and 50 us".
std::string reason(std::span<const Row> rows, const Demand& demand);

/// What to tell the user, as a sentence: "no method meets 0.1% and 5 us; in time the most exact is grip (4%
/// of v_td in 0.02 us), exact enough the fastest is ode tolerance=0.001 (0.04% of v_td in 9 us)".
std::string refusal(const Nearest& nearest, const Demand& demand);

/// Names of the quantities that lie outside of what a study's scenes spanned; those that have no range are
/// not judged.
struct Quantity {
  std::string_view name;
  double value = 0.0;
};
std::vector<std::string> outside(std::span<const Range> ranges, std::string_view study,
                                 std::span<const Quantity> quantities);

}  // namespace strobe::frontier
