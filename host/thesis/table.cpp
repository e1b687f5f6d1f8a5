#include "host/thesis/table.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace strobe::report {

namespace {

/// Printed decimals are not exact in binary: a difference of half a digit may come out a little larger.
constexpr double kSlack = 1e-9;

struct ReasonText {
  std::string_view name, phrase;
};

/// In the order of Reason.
constexpr std::array<ReasonText, 12> kReasons{{
    {"none", "beyond the thesis"},
    {"as_measured", "mean of replicates"},
    {"agrees", "same to the last printed digit"},
    {"rounding", "rounding of the printed numbers"},
    {"mean_of_function", "the mean of a function is not the function of the means"},
    {"unrounded_inputs", "computed by the thesis from unrounded numbers"},
    {"simplified_form", "the thesis's simplified integral"},
    {"model", "a model's value beside a measured one"},
    {"misprint", "misprint"},
    {"inconsistent", "does not fit the other printed numbers; the right value is not known"},
    {"not_at_hand", "printed value not at hand"},
    {"unexplained", "unexplained"},
}};
static_assert(kReasons.size() == static_cast<std::size_t>(Reason::unexplained) + 1);

}  // namespace

std::string_view name(Reason reason) { return kReasons[static_cast<std::size_t>(reason)].name; }
std::string_view phrase(Reason reason) { return kReasons[static_cast<std::size_t>(reason)].phrase; }

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
