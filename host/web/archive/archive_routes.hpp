// Sessions over HTTP: see host/web/README.md.
#pragma once

#include "host/web/archive/photograph_store.hpp"
#include "host/web/archive/report_maker.hpp"
#include "host/web/archive/session_store.hpp"
#include "host/web/http/router.hpp"
#include "host/web/json/detail_json.hpp"

namespace strobe::web {

/// What the routes keep; it must outlive the router.
struct Archive {
  explicit Archive(SessionStoreSettings settings)
      : sessions(std::move(settings)), reports(sessions.settings().version) {}

  SessionStore sessions;
  PhotographStore photographs;
  ReportMaker reports;
};

void add_archive_routes(Router& router, Archive& archive);

/// A route of a shot, of which the name may have two parts ("3/1f2e4d"): rest is "" or "/photograph".
void add_shot_route(Router& router, const std::string& method, const std::string& rest,
                    Router::Handler handler);
/// What {session} and {shot} matched.
std::string session_of(const Request& request);
std::string shot_of(const Request& request);

/// detail_json() of the shot.
Answered<nlohmann::ordered_json> shot_detail(Archive& archive, const std::string& session,
                                             const ShotOfSession& shot);
/// Where its photograph is to be had; absent: it cannot be shown.
std::optional<PhotographPlace> photograph_place(Archive& archive, const std::string& session,
                                                const host::Shot& shot);
Response unanswered_response(const Unanswered& why);

}  // namespace strobe::web
