#include "host/thesis/tables/render.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "host/view/text.hpp"

namespace strobe::report {

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
  const bool numbered = table.id.find_first_not_of("0123456789") == std::string::npos;
  std::string out = numbered ? fmt::format("Table {}. {}\n", table.id, table.title)
                             : fmt::format("Table \"{}\". {}\n", table.id, table.title);
  out += laid_out(table) + tally(table) + differences(table) + remarks_alone(table);
  for (const std::string& note : table.notes) out += "  " + note + "\n";
  return out;
}

std::string json(const Table& table) {
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

}  // namespace strobe::report
