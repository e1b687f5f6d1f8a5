#include "host/report/content/summarize_shots.hpp"

#include <map>
#include <memory>

#include "host/report/content/content.hpp"
#include "host/series/select.hpp"
#include "host/series/series.hpp"

namespace strobe::lab_report {

Summarize summarize_shots(const std::vector<host::StoredSession>& sessions) {
  auto known = std::make_shared<std::map<const host::Shot*, host::Shot>>();
  for (const host::StoredSession& session : sessions) {
    const std::string name = sessions.size() == 1 ? "" : folder_name(session);
    auto shots = host::series_shots(session, name);  // in the session's order
    for (std::size_t i = 0; i < shots.size(); ++i) known->emplace(&session.shots[i], std::move(shots[i]));
  }
  return [known](const std::string& name, const std::vector<ReportShot>& shots) {
    std::vector<host::Shot> series;
    for (const ReportShot& each : shots) series.push_back(known->at(each.shot));
    return host::summarize(name, series);
  };
}

}  // namespace strobe::lab_report
