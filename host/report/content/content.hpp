// The sessions' shots by condition, with their statistics: what the sections of a report are written from. Pure;
// thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/report/content/report_input.hpp"

namespace strobe::lab_report {

/// Shots of the same spin and angle, as their records say.
struct ConditionGroup {
  std::string key;          ///< "zero_23"; "unnamed" without either
  std::string label;        ///< "no spin, 23°"
  std::string spin, angle;  ///< may be empty
  std::vector<ReportShot> shots;
  std::vector<ReportShot> counted;
  host::SeriesSummary summary;  ///< of those
  /// Of the shots that meet the limits of the court pace test; absent without one.
  std::optional<host::SeriesSummary> court_pace;
  const thesis::Condition* thesis = nullptr;  ///< the same one there

  const host::QuantitySummary& of(reduction::Quantity q) const {
    return summary.quantities[static_cast<std::size_t>(q)];
  }
};

struct Content {
  const ReportInput& input;
  host::Statements statements;             ///< all that are stated
  std::vector<ReportShot> shots;           ///< as fired
  std::vector<ConditionGroup> conditions;  ///< zero, top, back spin, then others; by angle
  std::string first_day, last_day;         ///< of the shots; empty without any

  std::string stated(const std::string& id) const {
    const auto found = statements.find(id);
    return found == statements.end() ? std::string() : found->second;
  }
};

/// The last part of its path.
std::string folder_name(const host::StoredSession& session);

/// The input must outlive it.
Content content_of(const ReportInput& input);

}  // namespace strobe::lab_report
