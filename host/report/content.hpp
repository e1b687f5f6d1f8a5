// What a report is made of, and the sessions' shots by condition with their statistics: what its sections are
// written from. Plain values and pure functions; thread-safe; they allocate.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/archive/read_session.hpp"
#include "host/config/notes.hpp"
#include "host/protocol/session_protocol.hpp"
#include "host/report/conformity.hpp"
#include "host/series/series.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::report {

struct ReportInput {
  std::vector<host::StoredSession> sessions{};  ///< at least one
  host::Statements statements{};                ///< in force before those of the rig files
  std::vector<Limit> limits{};
  DecisionRule rule = DecisionRule::guarded;
  std::vector<std::string> over{};  ///< what shots of one condition may differ in: host::kConditionKeys
  bool all = false;                 ///< all quantities, budgets and figures of every condition
  std::string version{};            ///< of strobe
  std::optional<protocol::SessionProtocol> protocol{};  ///< that the first session was fired for
  /// The thesis's conditions and fitted contact mechanics; nullptr: nothing is set beside.
  const thesis::ThesisInputs* thesis = nullptr;
  /// Told of the work: done, of, and at what. Empty: nobody.
  std::function<void(std::size_t, std::size_t, const std::string&)> progress{};
};

struct ReportShot {
  const host::StoredSession* session = nullptr;
  const host::Shot* shot = nullptr;
  std::string name;  ///< Shot::name; of several sessions, after the folder's
  bool counts = false;
  std::shared_ptr<const host::Shot> in_series{};  ///< with its budget; never null
};

/// Shots of the same spin and angle, and of all else that conditions differ in (host::kConditionKeys).
struct ConditionGroup {
  std::string key{};    ///< "zero_23"; "unnamed" without either
  std::string label{};  ///< "no spin, 23°, acrylic": of what is not spin and angle, where shots differ
  std::vector<std::string> mixed{};  ///< what its shots differ in all the same, as ReportInput::over allows
  std::string spin, angle;           ///< may be empty
  std::string spin_phrase{};         ///< "no spin"; of a spin that the thesis has not: its name
  std::vector<ReportShot> shots{};
  std::vector<ReportShot> counted{};
  host::SeriesSummary summary{};  ///< of those
  /// Of the shots that meet the limits of the court pace test; absent without one.
  std::optional<host::SeriesSummary> court_pace{};
  const thesis::Condition* thesis = nullptr;  ///< the same one there

  const host::QuantitySummary& of(reduction::Quantity q) const {
    return summary.quantities[static_cast<std::size_t>(q)];
  }
};

/// Whether the thesis has the spin: zero, top, back.
bool is_known_spin(const std::string& spin);

struct Content {
  const ReportInput& input;
  host::Statements statements{};             ///< all that are stated
  std::vector<ReportShot> shots{};           ///< as fired
  std::vector<ConditionGroup> conditions{};  ///< zero, top, back spin, then others; by angle
  std::string first_day{}, last_day{};       ///< of the shots; empty without any

  /// Empty: nobody said it.
  std::string stated(const std::string& id) const {
    const auto found = statements.find(id);
    return found == statements.end() ? std::string() : found->second;
  }
  /// Each session with what tells its keys in JSON from others': "" of a single one, else "_1", "_2" ...
  std::vector<std::pair<const host::StoredSession*, std::string>> sessions() const;
};

/// Whether its calibration was due before the tests ended.
bool is_overdue(const host::Instrument& instrument, const Content& content);

/// The last part of its path.
std::string folder_name(const host::StoredSession& session);

/// The input must outlive it. Makes the budget of each shot: some milliseconds each.
Content content_of(const ReportInput& input);

}  // namespace strobe::report
