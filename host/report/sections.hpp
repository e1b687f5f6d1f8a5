// The parts of a report, in their order, and the pieces that they are written with. All but commissioning(),
// promises(), photographs() and records(), which read the session's files, are pure; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/report/content.hpp"
#include "host/report/model.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::report {

/// Who, for whom, what, when; who signs.
Section identification(const Content& content, const std::string& issued);
/// Against limits and the court pace test.
Section conformity(const Content& content);
/// Of a session that was fired for a protocol: verdict, numbers, shots; else a section without blocks.
Section test_by_protocol(const Content& content);
/// Means with expanded uncertainties, by the thesis's tables.
Section results(const Content& content);
/// How it was measured, what the uncertainty means, deviations.
Section method(const Content& content);
/// Rig, ball, camera and its calibration, runs.
Section set_up(const Content& content);
/// What proved the rig: the record of commissioning that the session keeps.
Section commissioning(const Content& content);
/// Of the session's own data.
Section figures(const Content& content);
/// The images in contact; a section without blocks where there are none, or no thesis to set them beside.
Section contact_figures(const Content& content);
/// What was foretold, and what it became; a section without blocks where nothing was.
Section promises(const Content& content);
/// Control charts of what each shot says of scale, clock, inclination, lens and lamps.
Section witnesses(const Content& content);
/// Each shot in numbers; those that do not count, with the reasons.
Section shots(const Content& content);
/// Each shot's photograph with what was found on it.
Section photographs(const Content& content);
/// What the uncertainties are made of.
Section budgets(const Content& content);
/// How the flashes came.
Section timing(const Content& content);
/// Versions and hashes of files.
Section records(const Content& content);
/// Where what ISO/IEC 17025 asks for stands, and what is not stated.
Section clauses(const std::vector<Section>& before);

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
/// The first ones of them, as many as a table of shots or a run chart has room for.
inline constexpr std::size_t kFewQuantities = 9;

/// The essential ones, at most so many, or all.
std::vector<reduction::Quantity> quantities_of(const ReportInput& input,
                                               std::size_t most = std::size(kEssential));

inline const host::QuantityLabel& label_of(reduction::Quantity q) {
  return host::kQuantityLabels[static_cast<std::size_t>(q)];
}
/// "speed touchdown, m/s"
std::string axis_name(reduction::Quantity q);

Fact fact(std::string key, std::string label, std::string text);
/// Empty text: not stated.
Fact stated_fact(std::string key, std::string label, const std::string& text);
Fact number_fact(std::string key, std::string label, double number, std::string text);

/// Of words, with the key as its heading or another one.
Column text_column(std::string key);
Column text_column(std::string key, std::string head);
Column number_column(std::string key);
Column number_column(std::string key, std::string head, std::string unit = "");
Column quantity_column(reduction::Quantity q);

/// As many decimals as two digits of `sd` have; without an sd four significant digits. "-" without a value.
Cell number_cell(std::optional<double> value, std::optional<double> sd);
/// As sds are shown: two significant digits.
Cell sd_cell(std::optional<double> sd);
Cell count_cell(long count);
/// "15.62 ± 0.03", both with two digits of the uncertainty; the number is the value.
Cell expanded_cell(const host::QuantitySummary& summary);
Cell expanded_cell(double value, const std::optional<double>& u);
/// "12.3"; "∞" of more than 10,000 or infinitely many.
Cell freedom_cell(const std::optional<double>& degrees_of_freedom);

/// `text` after what is there already, and a separator.
void append(std::string& list, std::string_view text, std::string_view separator = ", ");

}  // namespace strobe::report
