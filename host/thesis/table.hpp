// A table of the thesis recomputed: printed beside computed values, with the reason for every difference.
// Plain values and pure functions; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/data/thesis_data.hpp"

namespace strobe::thesis {

/// Why a printed and a computed value differ, or why there is only one of them.
enum class Reason {
  none,              ///< a value beyond the thesis: nothing is printed
  as_measured,       ///< a mean of replicates, which are not available: it cannot be computed
  agrees,            ///< the same to the last printed digit
  rounding,          ///< within what the rounding of the printed numbers gives
  mean_of_function,  ///< a mean of angles, speeds or ratios is not that of the means: within the second order
  unrounded_inputs,  ///< the thesis computed it from unrounded numbers that are not printed
  simplified_form,   ///< the thesis's simplified integral of the pulse
  model,             ///< a model's value beside a measured one
  misprint,          ///< an erratum; the remark gives its reason
  inconsistent,      ///< contradicts the other printed numbers; the right value is unknown
  not_at_hand,       ///< the printed value is not available
  unexplained,
};

/// An identifier ("mean_of_function") and a phrase.
std::string_view name(Reason reason);
std::string_view phrase(Reason reason);

struct Cell {
  std::optional<double> printed{};
  double last_digit = 0.0;  ///< unit of the printed value's last digit
  std::optional<double> printed_sd{};
  std::optional<double> computed{};
  std::optional<double> computed_sd{};
  std::string text{};  ///< instead of numbers
  Reason reason = Reason::none;
  double allowed = 0.0;  ///< largest difference that the reason explains; 0 if it has no limit
  std::string remark{};

  /// Printed less computed. Returns nullopt unless both are present.
  std::optional<double> difference() const;
  /// Whether the difference is larger than rounding explains.
  bool differs() const;
};

struct Column {
  std::string key;   ///< with its unit, e.g. "vx_td_mps"
  std::string head;  ///< e.g. "vx TD"
  std::string unit;
  int decimals = 2;
};

struct Row {
  std::string label;        ///< a set's name, or the row's subject
  std::vector<Cell> cells;  ///< one for each column
};

struct Table {
  std::string id;  ///< "2" … "17" as in the thesis, a word beyond it
  std::string title;
  std::vector<Column> columns{};
  std::vector<Row> rows{};
  std::vector<std::string> notes{};
};

struct Printed {
  double value = 0.0;
  double last_digit = 0.01;
  std::optional<double> sd;
};

/// Largest differences expected between a printed value and the one computed from the other printed values.
struct Tolerance {
  double rounding = 0.0;      ///< the inputs' rounding, propagated
  double second_order = 0.0;  ///< mean of the function less function of the means
};

/// A computed value beside the printed one, with the reason agrees, rounding, mean_of_function or
/// unexplained.
Cell compared(const Printed& printed, double computed, const Tolerance& tolerance = {});

/// A printed mean with nothing to compute it from.
Cell as_measured(const Printed& printed);

/// A computed value with nothing printed beside it.
Cell computed_only(std::optional<double> value, std::optional<double> sd = std::nullopt,
                   Reason reason = Reason::none);

Cell text_cell(std::string text);

// A table as text for people and as JSON for scripts. Pure; thread-safe; allocates.

/// Title, one or two lines for each row (printed, recomputed; a * marks differences larger than rounding),
/// then every difference with its reason, then the notes.
std::string text(const Table& table);

/// One object without line breaks: table, title, columns (key, unit), rows (label and, by the columns' keys,
/// printed, printed_sd, computed, sd, difference, last_digits, difference_over_sd, reason, allowed, remark;
/// absent values left out), notes. Numbers are printed shortest-round-trip.
std::string json(const Table& table);

// Tolerances of derived values: how much the mean of a function of two quantities may differ from the
// function of the printed means, by the rounding of the inputs (half a digit each, first order) and by the
// spread of the replicates (second order: half the trace of Hessian times covariance, the largest over all
// correlations). Pure; thread-safe; no allocation.

/// Half a digit of the printed means, all of which have two decimals.
inline constexpr double kHalfDigit = 0.005;

struct DerivedValue {
  double value = 0.0;
  Tolerance tolerance;
};

DerivedValue angle_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy);
DerivedValue speed(const thesis::MeanSd& vx, const thesis::MeanSd& vy);
/// -vy_LO/vy_TD
DerivedValue restitution(const thesis::Condition& condition);
/// (vx_TD - vx_LO)/(vy_LO - vy_TD)
DerivedValue impulse_ratio(const thesis::Condition& condition);
/// Sd of the angle from those of the components and of the speed: sd(vx)² + sd(vy)² = sd(v)² + v²·sd(theta)²
/// to first order, whatever the correlation. The bound for the next order is (sd/v)² of the value, times
/// four.
DerivedValue angle_sd_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy, const thesis::MeanSd& v);

}  // namespace strobe::thesis
