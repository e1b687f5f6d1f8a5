#include "host/thesis/table.hpp"

#include <cmath>
#include <utility>

namespace strobe::report {

namespace {

/// Printed decimals are not exact in binary: a difference of half a digit may come out a little larger.
constexpr double kSlack = 1e-9;

}  // namespace

std::string_view name(Reason reason) {
  switch (reason) {
    case Reason::none:
      return "none";
    case Reason::as_measured:
      return "as_measured";
    case Reason::agrees:
      return "agrees";
    case Reason::rounding:
      return "rounding";
    case Reason::mean_of_function:
      return "mean_of_function";
    case Reason::unrounded_inputs:
      return "unrounded_inputs";
    case Reason::simplified_form:
      return "simplified_form";
    case Reason::model:
      return "model";
    case Reason::misprint:
      return "misprint";
    case Reason::inconsistent:
      return "inconsistent";
    case Reason::not_at_hand:
      return "not_at_hand";
    case Reason::unexplained:
      return "unexplained";
  }
  return "unexplained";
}

std::string_view phrase(Reason reason) {
  switch (reason) {
    case Reason::none:
      return "beyond the thesis";
    case Reason::as_measured:
      return "mean of replicates";
    case Reason::agrees:
      return "same to the last printed digit";
    case Reason::rounding:
      return "rounding of the printed numbers";
    case Reason::mean_of_function:
      return "the mean of a function is not the function of the means";
    case Reason::unrounded_inputs:
      return "computed by the thesis from unrounded numbers";
    case Reason::simplified_form:
      return "the thesis's simplified integral";
    case Reason::model:
      return "a model's value beside a measured one";
    case Reason::misprint:
      return "misprint";
    case Reason::inconsistent:
      return "does not fit the other printed numbers; the right value is not known";
    case Reason::not_at_hand:
      return "printed value not at hand";
    case Reason::unexplained:
      return "unexplained";
  }
  return "unexplained";
}

std::optional<double> Cell::difference() const {
  if (!printed || !computed) return std::nullopt;
  return *printed - *computed;
}

bool Cell::differs() const { return difference() && reason != Reason::agrees && reason != Reason::rounding; }

Cell compared(const Printed& printed, double computed, const Tolerance& tolerance) {
  Cell cell{.printed = printed.value, .last_digit = printed.last_digit, .printed_sd = printed.sd};
  cell.computed = computed;
  const double difference = std::abs(printed.value - computed);
  const double half = printed.last_digit * (0.5 + kSlack);
  const double rounding = half + tolerance.rounding;
  if (difference <= half) {
    cell.reason = Reason::agrees;
    cell.allowed = half;
  } else if (difference <= rounding) {
    cell.reason = Reason::rounding;
    cell.allowed = rounding;
  } else if (difference <= rounding + tolerance.second_order) {
    cell.reason = Reason::mean_of_function;
    cell.allowed = rounding + tolerance.second_order;
  } else {
    cell.reason = Reason::unexplained;
    cell.allowed = rounding + tolerance.second_order;
  }
  return cell;
}

Cell as_measured(const Printed& printed) {
  Cell cell{.printed = printed.value, .last_digit = printed.last_digit, .printed_sd = printed.sd};
  cell.reason = Reason::as_measured;
  return cell;
}

Cell computed_only(std::optional<double> value, std::optional<double> sd, Reason reason) {
  Cell cell;
  cell.computed = value;
  cell.computed_sd = sd;
  cell.reason = reason;
  return cell;
}

Cell text_cell(std::string text) {
  Cell cell;
  cell.text = std::move(text);
  return cell;
}

}  // namespace strobe::report
