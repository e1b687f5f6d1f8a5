// Laboratories' reported results, side by side: read from JSON, compared, told as text, JSON and a figure.
// Pure; thread-safe; allocates.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "host/figures/figure.hpp"
#include "host/interlaboratory/scores.hpp"

namespace strobe::interlaboratory {

/// One number that a laboratory reports.
struct ReportedValue {
  std::string quantity;
  std::string unit;  ///< may be empty
  double value = 0.0;
  double standard_uncertainty = 0.0;  ///< > 0
  double expanded_uncertainty = 0.0;  ///< > 0, 95 %
};

struct LaboratoryReport {
  std::string laboratory;
  std::vector<ReportedValue> values;
};

/// JSON, whole or an object a line, of these shapes:
/// {"laboratory": "north", "results": [{"name": "e", "value": 0.858, "expanded_uncertainty": 0.012, "unit":
/// "", "standard_uncertainty": 0.006}, …]}: the laboratory, the unit and the standard uncertainty (half of
/// the expanded one) may be left out;
/// {"series": "today", "quantities": {"e": {"mean": …, "total_sd": …, "expanded_uncertainty": …}, …}}: what
/// `strobe series --json` prints; of several series the quantities are called "SERIES: e";
/// {"protocol": …, "values": [{"name": "rating", "of": {…}, "value": …, "sd": …, "expanded_uncertainty": …},
/// …]}: what `strobe protocol verdict --json` prints; values of single shots are passed over. What has no
/// uncertainty is passed over. laboratory: in place of the file's; file_name: for messages, and the
/// laboratory where nothing else names it. Fails with "FILE: what".
Result<LaboratoryReport> read_report(std::string_view text, const std::string& file_name,
                                     const std::string& laboratory);

struct ComparisonTerms {
  std::string reference;                        ///< as Terms::reference
  std::map<std::string, double> assessment_sd;  ///< by quantity
  std::vector<std::string> quantities;          ///< only these; empty: all that two or more have
};

/// One quantity of those that have it.
struct ComparedQuantity {
  std::string quantity, unit;
  std::vector<LaboratoryResult> results;
  Agreement agreement;
};

struct Comparison {
  std::vector<std::string> laboratories;  ///< in the order in which they were given
  std::vector<ComparedQuantity> quantities;
  std::vector<std::string> remarks;  ///< a sentence for each quantity that cannot be compared
};

/// Fails with one line: laboratories of one name, a reference or a quantity that nobody has, units that
/// differ, nothing in common.
Result<Comparison> compare(const std::vector<LaboratoryReport>& reports, const ComparisonTerms& terms);

/// Whether no score of any laboratory is unsatisfactory.
bool all_agree(const Comparison& comparison);

std::vector<std::string> comparison_text(const Comparison& comparison);
/// One object without line breaks: quantity, unit, assigned, assessment_sd, results with scores.
std::string comparison_json(const ComparedQuantity& compared);

/// A panel a quantity: each laboratory's value with its expanded uncertainty, at 1, 2, 3 … by its place among
/// the laboratories, and the assigned value with its own.
figures::Figure comparison_figure(const Comparison& comparison);

}  // namespace strobe::interlaboratory
