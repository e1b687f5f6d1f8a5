// Pieces that sections are written with. Pure; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/report/content/content.hpp"
#include "host/report/model/model.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::lab_report {

inline constexpr const char* kNotStated = "not stated";

/// Speeds, angles, spins, e, mu, dwell: what most readers come for.
inline constexpr reduction::Quantity kEssential[] = {reduction::Quantity::theta_in_deg,
                                                     reduction::Quantity::v_td_mps,
                                                     reduction::Quantity::omega_td_radps,
                                                     reduction::Quantity::theta_out_deg,
                                                     reduction::Quantity::v_lo_mps,
                                                     reduction::Quantity::omega_lo_radps,
                                                     reduction::Quantity::e,
                                                     reduction::Quantity::mu,
                                                     reduction::Quantity::dwell_time_ms,
                                                     reduction::Quantity::dwell_distance_cm};

/// The essential ones, or all.
std::vector<reduction::Quantity> quantities_of(const ReportInput& input);

inline const host::QuantityLabel& label_of(reduction::Quantity q) {
  return host::kQuantityLabels[static_cast<std::size_t>(q)];
}
/// With its unit in brackets.
std::string axis_name(reduction::Quantity q);

Fact fact(std::string key, std::string label, std::string text);
/// Empty text: not stated.
Fact stated_fact(std::string key, std::string label, const std::string& text);
Fact number_fact(std::string key, std::string label, double number, std::string text);

/// As many decimals as two digits of `sd` have; without an sd four significant digits. "-" without a value.
Cell number_cell(std::optional<double> value, std::optional<double> sd);
/// As sds are shown: two significant digits.
Cell sd_cell(std::optional<double> sd);
Cell count_cell(long count);
Cell text_cell(std::string text);

/// "15.62 ± 0.03"; the number is the value.
Cell expanded_cell(const host::QuantitySummary& summary);

/// Expanded over total standard uncertainty.
std::optional<double> coverage_factor(const host::QuantitySummary& summary);

}  // namespace strobe::lab_report
