#include "host/report/sections/parts.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host/text/text.hpp"

namespace strobe::lab_report {

std::vector<reduction::Quantity> quantities_of(const ReportInput& input) {
  if (!input.all) return {std::begin(kEssential), std::end(kEssential)};
  std::vector<reduction::Quantity> all;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    all.push_back(static_cast<reduction::Quantity>(i));
  return all;
}

std::string axis_name(reduction::Quantity q) {
  const host::QuantityLabel& label = label_of(q);
  return std::string(label.words) + (label.unit.empty() ? "" : ", " + std::string(label.unit));
}

Fact fact(std::string key, std::string label, std::string text) {
  return {.key = std::move(key), .label = std::move(label), .text = std::move(text), .number = {}};
}

Fact stated_fact(std::string key, std::string label, const std::string& text) {
  Fact out = fact(std::move(key), std::move(label), text.empty() ? kNotStated : text);
  out.stated = !text.empty();
  return out;
}

Fact number_fact(std::string key, std::string label, double number, std::string text) {
  Fact out = fact(std::move(key), std::move(label), std::move(text));
  out.number = number;
  return out;
}

Cell number_cell(std::optional<double> value, std::optional<double> sd) {
  if (!value || !std::isfinite(*value)) return {"-", {}};
  if (sd && std::isfinite(*sd) && *sd > 0.0) return {host::rounded(*value, *sd), value};
  return {fmt::format("{:.4g}", *value), value};
}

Cell sd_cell(std::optional<double> sd) {
  if (!sd || !std::isfinite(*sd)) return {"-", {}};
  if (*sd > 0.0 && *sd < 1e-5) return {fmt::format("{:.1e}", *sd), sd};  // beyond six decimals
  return {*sd > 0.0 ? host::rounded(*sd, *sd) : "0", sd};
}

Cell count_cell(long count) { return {fmt::format("{}", count), static_cast<double>(count)}; }

Cell text_cell(std::string text) { return {std::move(text), {}}; }

Cell expanded_cell(const host::QuantitySummary& summary) {
  if (summary.n == 0) return {"-", {}};
  const auto& u = summary.expanded_uncertainty;
  Cell cell = number_cell(summary.mean, u);
  if (u && *u > 0.0 && std::isfinite(*u)) cell.text += " ± " + host::rounded(*u, *u);
  return cell;
}

std::optional<double> coverage_factor(const host::QuantitySummary& s) {
  if (!s.expanded_uncertainty || !s.total_sd || !(*s.total_sd > 0.0)) return std::nullopt;
  return *s.expanded_uncertainty / *s.total_sd;
}

}  // namespace strobe::lab_report
