#include "host/report/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/text/text.hpp"

namespace strobe::report {

using reduction::Quantity;

std::vector<Quantity> quantities_of(const ReportInput& input, std::size_t most) {
  if (!input.all) return {std::begin(kEssential), std::begin(kEssential) + static_cast<long>(most)};
  std::vector<Quantity> all;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) all.push_back(static_cast<Quantity>(i));
  return all;
}

std::string axis_name(Quantity q) {
  std::string text(label_of(q).words);
  if (const auto unit = label_of(q).unit; !unit.empty()) append(text, unit);
  return text;
}

Fact fact(std::string key, std::string label, std::string text) {
  return {.key = std::move(key), .label = std::move(label), .text = std::move(text)};
}

Fact stated_fact(std::string key, std::string label, const std::string& text) {
  Fact out = fact(std::move(key), std::move(label), text.empty() ? "not stated" : text);
  out.stated = !text.empty();
  return out;
}

Fact number_fact(std::string key, std::string label, double number, std::string text) {
  Fact out = fact(std::move(key), std::move(label), std::move(text));
  out.number = number;
  return out;
}

Column text_column(std::string key, std::string head) { return {std::move(key), std::move(head), "", false}; }

Column text_column(std::string key) { return text_column(key, key); }

Column number_column(std::string key, std::string head, std::string unit) {
  return {std::move(key), std::move(head), std::move(unit), true};
}

Column number_column(std::string key) { return number_column(key, key); }

Column quantity_column(Quantity q) {
  return number_column(std::string(name(q)), std::string(label_of(q).words), std::string(label_of(q).unit));
}

Cell number_cell(std::optional<double> value, std::optional<double> sd) {
  if (!value || !std::isfinite(*value)) return "-";
  if (sd && std::isfinite(*sd) && *sd > 0.0) return {host::rounded(*value, *sd), value};
  return {fmt::format("{:.4g}", *value), value};
}

Cell sd_cell(std::optional<double> sd) {
  if (!sd || !std::isfinite(*sd)) return "-";
  if (*sd > 0.0 && *sd < 1e-5) return {fmt::format("{:.1e}", *sd), sd};  // beyond six decimals
  return {*sd > 0.0 ? host::rounded(*sd, *sd) : "0", sd};
}

Cell count_cell(long count) { return {fmt::format("{}", count), static_cast<double>(count)}; }

Cell expanded_cell(const host::QuantitySummary& summary) {
  if (summary.n == 0) return "-";
  return expanded_cell(summary.mean, summary.expanded_uncertainty);
}

Cell expanded_cell(double value, const std::optional<double>& u) {
  Cell cell = number_cell(value, u);
  if (u && *u > 0.0 && std::isfinite(*u)) cell.text += " ± " + host::rounded(*u, *u);
  return cell;
}

Cell freedom_cell(const std::optional<double>& degrees_of_freedom) {
  if (!degrees_of_freedom || !(*degrees_of_freedom < 1e4)) return "∞";
  return {fmt::format("{:.1f}", *degrees_of_freedom), degrees_of_freedom};
}

void append(std::string& list, std::string_view text, std::string_view separator) {
  if (!list.empty()) list += separator;
  list += text;
}

}  // namespace strobe::report
