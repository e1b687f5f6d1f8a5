// What a report is made of. Plain values; thread-safe.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/archive/read_session.hpp"
#include "host/config/notes.hpp"
#include "host/report/content/conformity.hpp"
#include "host/series/series.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::lab_report {

struct ReportShot {
  const host::StoredSession* session = nullptr;
  const host::Shot* shot = nullptr;
  std::string name;  ///< Shot::name; of several sessions, after the folder's
  bool counts = false;
};

/// A series' statistics; the shots all count.
using Summarize =
    std::function<host::SeriesSummary(const std::string& name, const std::vector<ReportShot>& shots)>;

struct ReportInput {
  std::vector<host::StoredSession> sessions;  ///< at least one
  host::Statements statements;                ///< in force before those of the rig files
  std::vector<Limit> limits;
  DecisionRule rule = DecisionRule::guarded;
  bool all = false;     ///< all quantities, budgets and figures of every condition
  std::string version;  ///< of strobe
  Summarize summarize;
  /// The thesis's conditions and fitted contact mechanics; nullptr: nothing is set beside.
  const thesis::ThesisInputs* thesis = nullptr;
  /// Told of the work: done, of, and at what. Empty: nobody.
  std::function<void(std::size_t, std::size_t, const std::string&)> progress;
};

}  // namespace strobe::lab_report
