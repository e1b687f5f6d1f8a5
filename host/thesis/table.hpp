// A table of the thesis recomputed: printed beside computed values, with the reason for every difference.
// Plain values and pure functions; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace strobe::report {

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

}  // namespace strobe::report
