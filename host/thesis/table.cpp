#include "host/thesis/table.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/messages/parsed_json.hpp"
#include "common/units/angles.hpp"
#include "host/text/text.hpp"

namespace strobe::thesis {

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

namespace {

using nlohmann::ordered_json;

std::string number(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  std::string text = fmt::format("{:.{}f}", value, decimals);
  const bool zero = text.find_first_not_of("-0.") == std::string::npos;
  return zero && text.front() == '-' ? text.substr(1) : text;
}

std::string with_sd(std::optional<double> value, std::optional<double> sd, int decimals) {
  if (!value) return {};
  std::string text = number(*value, decimals);
  if (sd && std::isfinite(*sd)) text += " ± " + number(*sd, decimals);
  return text;
}

std::string printed_text(const Cell& cell, const Column& column) {
  return with_sd(cell.printed, cell.printed_sd, column.decimals);
}

/// Right-aligned numbers keep their columns when a mark follows them.
std::string computed_text(const Cell& cell, const Column& column) {
  if (!cell.text.empty()) return cell.text + " ";
  if (!cell.computed) return {};
  return with_sd(cell.computed, cell.computed_sd, column.decimals) + (cell.differs() ? "*" : " ");
}

struct Line {
  std::string label;
  std::string which;  ///< "printed", "anew" or nothing
  std::vector<std::string> cells;
  bool joined = false;
};

bool empty(const Line& line) {
  return std::all_of(line.cells.begin(), line.cells.end(), [](const std::string& c) { return c.empty(); });
}

std::vector<Line> lines_of(const Table& table) {
  std::vector<Line> lines;
  for (const Row& row : table.rows) {
    Line printed{row.label, "printed", {}};
    Line anew{row.label, "anew", {}};
    for (std::size_t i = 0; i < row.cells.size(); ++i) {
      const std::string text = printed_text(row.cells[i], table.columns[i]);
      printed.cells.push_back(text.empty() ? text : text + " ");
      anew.cells.push_back(computed_text(row.cells[i], table.columns[i]));
    }
    const bool both = !empty(printed) && !empty(anew);
    if (both) anew.label.clear();
    if (!empty(printed)) lines.push_back(printed);
    if (!empty(anew) || !both) lines.push_back(anew);
    if (empty(printed) && empty(anew)) lines.pop_back();
  }
  const bool any_printed =
      std::any_of(lines.begin(), lines.end(), [](const Line& l) { return l.which == "printed"; });
  if (!any_printed)
    for (Line& line : lines) line.which.clear();
  return lines;
}

std::string laid_out(const Table& table) {
  const std::vector<Line> lines = lines_of(table);
  std::size_t label = 0;
  std::size_t which = 0;
  std::vector<std::size_t> widths;
  for (const Column& column : table.columns)
    widths.push_back(std::max(host::columns(column.head), host::columns(column.unit)) + 1);
  for (const Line& line : lines) {
    label = std::max(label, host::columns(line.label));
    which = std::max(which, host::columns(line.which));
    for (std::size_t i = 0; i < widths.size(); ++i)
      widths[i] = std::max(widths[i], host::columns(line.cells[i]));
  }
  const std::size_t margin = label + 2 + which;
  std::string out;
  const auto add = [&out](std::string line) {
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  };
  std::string heads(margin, ' ');
  std::string units(margin, ' ');
  for (std::size_t i = 0; i < widths.size(); ++i) {
    heads += "  " + host::right(table.columns[i].head + " ", widths[i]);
    units += "  " + host::right(table.columns[i].unit + " ", widths[i]);
  }
  add(heads);
  if (units.find_first_not_of(' ') != std::string::npos) add(units);
  for (const Line& line : lines) {
    std::string text = host::left(line.label, label) + "  " + host::left(line.which, which);
    for (std::size_t i = 0; i < widths.size(); ++i) text += "  " + host::right(line.cells[i], widths[i]);
    add(std::move(text));
  }
  return out;
}

std::string signed_number(double value, int decimals) {
  const std::string text = number(value, decimals);
  return text.front() == '-' || value == 0.0 ? text : "+" + text;
}

std::string difference_line(const Row& row, const Cell& cell, const Column& column) {
  const double difference = *cell.difference();
  std::string line = fmt::format(
      "    {} {}: {} printed, {} anew, {}", row.label, column.head, number(*cell.printed, column.decimals),
      number(*cell.computed, column.decimals + 1), signed_number(difference, column.decimals + 1));
  if (cell.last_digit > 0.0)
    line += fmt::format(" = {} last digits", signed_number(difference / cell.last_digit, 1));
  const auto sd = cell.computed_sd ? cell.computed_sd : cell.printed_sd;
  if (sd && *sd > 0.0) line += fmt::format(", {} sd", signed_number(difference / *sd, 2));
  if (cell.allowed > 0.0 && cell.reason == Reason::mean_of_function)
    line += fmt::format(" (up to {} explained)", number(cell.allowed, column.decimals + 1));
  if (!cell.remark.empty()) line += "; " + cell.remark;
  return line + "\n";
}

std::string differences(const Table& table) {
  constexpr Reason kInOrder[] = {Reason::misprint,         Reason::inconsistent,    Reason::mean_of_function,
                                 Reason::unrounded_inputs, Reason::simplified_form, Reason::model,
                                 Reason::unexplained};
  std::string out;
  for (const Reason reason : kInOrder) {
    std::string part;
    for (const Row& row : table.rows)
      for (std::size_t i = 0; i < row.cells.size(); ++i)
        if (row.cells[i].reason == reason && row.cells[i].difference())
          part += difference_line(row, row.cells[i], table.columns[i]);
    if (!part.empty()) out += fmt::format("  differences, {}:\n{}", phrase(reason), part);
  }
  return out;
}

/// How many printed values were met to the last digit or within rounding, and which are not at hand.
std::string tally(const Table& table) {
  int agree = 0;
  int rounded = 0;
  int absent = 0;
  for (const Row& row : table.rows) {
    for (const Cell& cell : row.cells) {
      agree += cell.reason == Reason::agrees ? 1 : 0;
      rounded += cell.reason == Reason::rounding ? 1 : 0;
      absent += cell.reason == Reason::not_at_hand ? 1 : 0;
    }
  }
  std::string out;
  if (agree + rounded > 0)
    out += fmt::format(
        "  {} computed to the last printed digit, {} within the rounding of what they are "
        "computed from\n",
        agree, rounded);
  if (absent > 0) out += fmt::format("  printed value not at hand: {} of the values\n", absent);
  return out;
}

std::string remarks_alone(const Table& table) {
  std::string out;
  for (const Row& row : table.rows)
    for (std::size_t i = 0; i < row.cells.size(); ++i)
      if (!row.cells[i].remark.empty() && !row.cells[i].difference())
        out += fmt::format("  {} {}: {}\n", row.label, table.columns[i].head, row.cells[i].remark);
  return out;
}

[[maybe_unused]] bool is_rectangular(const Table& table) {
  return std::ranges::all_of(table.rows,
                             [&table](const Row& row) { return row.cells.size() == table.columns.size(); });
}

ordered_json json_of(const Cell& cell) {
  ordered_json out = ordered_json::object();
  if (!cell.text.empty()) out["text"] = cell.text;
  const auto put = [&out](const char* key, const std::optional<double>& value) {
    if (value && std::isfinite(*value)) out[key] = *value;
  };
  put("printed", cell.printed);
  put("printed_sd", cell.printed_sd);
  put("computed", cell.computed);
  put("sd", cell.computed_sd);
  if (const auto difference = cell.difference(); difference && std::isfinite(*difference)) {
    out["difference"] = *difference;
    if (cell.last_digit > 0.0) out["last_digits"] = *difference / cell.last_digit;
    const auto sd = cell.computed_sd ? cell.computed_sd : cell.printed_sd;
    if (sd && *sd > 0.0) out["difference_over_sd"] = *difference / *sd;
  }
  if (cell.reason != Reason::none) out["reason"] = name(cell.reason);
  if (cell.allowed > 0.0) out["allowed"] = cell.allowed;
  if (!cell.remark.empty()) out["remark"] = cell.remark;
  return out;
}

}  // namespace

std::string text(const Table& table) {
  assert(is_rectangular(table));
  const bool numbered = table.id.find_first_not_of("0123456789") == std::string::npos;
  std::string out = numbered ? fmt::format("Table {}. {}\n", table.id, table.title)
                             : fmt::format("Table \"{}\". {}\n", table.id, table.title);
  out += laid_out(table) + tally(table) + differences(table) + remarks_alone(table);
  for (const std::string& note : table.notes) out += "  " + note + "\n";
  return out;
}

std::string json(const Table& table) {
  assert(is_rectangular(table));
  ordered_json columns = ordered_json::array();
  for (const Column& column : table.columns) columns.push_back({{"key", column.key}, {"unit", column.unit}});
  ordered_json rows = ordered_json::array();
  for (const Row& row : table.rows) {
    ordered_json entry{{"label", row.label}};
    for (std::size_t i = 0; i < row.cells.size(); ++i) entry[table.columns[i].key] = json_of(row.cells[i]);
    rows.push_back(std::move(entry));
  }
  const ordered_json out{{"table", table.id},
                         {"title", table.title},
                         {"columns", std::move(columns)},
                         {"rows", std::move(rows)},
                         {"notes", table.notes}};
  return messages::json_text(out);
}

namespace {

struct Curvature {
  double xx, xy, yy;
};

/// The largest |½ tr(H·Σ)| over correlations -1…1.
double second_order(const Curvature& h, double sd_x, double sd_y) {
  const double own = h.xx * sd_x * sd_x + h.yy * sd_y * sd_y;
  const double mixed = 2.0 * h.xy * sd_x * sd_y;
  return 0.5 * std::max(std::abs(own + mixed), std::abs(own - mixed));
}

/// a/b of two means.
DerivedValue ratio(double a, double sd_a, double half_a, double b, double sd_b, double half_b) {
  const double value = a / b;
  const double rounding = (half_a + std::abs(value) * half_b) / std::abs(b);
  const Curvature h{0.0, -1.0 / (b * b), 2.0 * a / (b * b * b)};
  return {value, {rounding, second_order(h, sd_a, sd_b)}};
}

}  // namespace

DerivedValue angle_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy) {
  const double x = vx.mean;
  const double y = vy.mean;
  const double squared = x * x + y * y;
  const double fourth = squared * squared;
  const Curvature h{2.0 * x * y / fourth, (y * y - x * x) / fourth, -2.0 * x * y / fourth};
  const double rounding = kHalfDigit * (std::abs(x) + std::abs(y)) / squared;
  return {degrees(std::atan2(y, x)), {degrees(rounding), degrees(second_order(h, vx.sd, vy.sd))}};
}

DerivedValue speed(const thesis::MeanSd& vx, const thesis::MeanSd& vy) {
  const double x = vx.mean;
  const double y = vy.mean;
  const double v = std::hypot(x, y);
  const double cubed = v * v * v;
  const Curvature h{y * y / cubed, -x * y / cubed, x * x / cubed};
  return {v, {kHalfDigit * (std::abs(x) + std::abs(y)) / v, second_order(h, vx.sd, vy.sd)}};
}

DerivedValue restitution(const thesis::Condition& c) {
  return ratio(c.vy_lo_mps.mean, c.vy_lo_mps.sd, kHalfDigit, -c.vy_td_mps.mean, c.vy_td_mps.sd, kHalfDigit);
}

DerivedValue impulse_ratio(const thesis::Condition& c) {
  return ratio(c.vx_td_mps.mean - c.vx_lo_mps.mean, c.vx_td_mps.sd + c.vx_lo_mps.sd, 2.0 * kHalfDigit,
               c.vy_lo_mps.mean - c.vy_td_mps.mean, c.vy_lo_mps.sd + c.vy_td_mps.sd, 2.0 * kHalfDigit);
}

DerivedValue angle_sd_deg(const thesis::MeanSd& vx, const thesis::MeanSd& vy, const thesis::MeanSd& v) {
  const double left = vx.sd * vx.sd + vy.sd * vy.sd - v.sd * v.sd;
  const double slack = 2.0 * kHalfDigit * (vx.sd + vy.sd + v.sd);
  const double speed = std::hypot(vx.mean, vy.mean);
  const auto sd = [speed](double variance) { return degrees(std::sqrt(std::max(0.0, variance)) / speed); };
  const double value = sd(left);
  const double rounding = std::max(sd(left + slack) - value, value - sd(left - slack));
  const double relative = (vx.sd * vx.sd + vy.sd * vy.sd) / (speed * speed);
  return {value, {rounding, 4.0 * relative * value}};
}

}  // namespace strobe::thesis
