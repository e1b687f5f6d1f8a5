// Sessions over HTTP: see host/web/README.md.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "host/web/detail_json.hpp"
#include "host/web/http/router.hpp"
#include "host/web/photograph_store.hpp"
#include "host/web/session_store.hpp"

namespace strobe::web {

/// What the routes keep; it must outlive the router.
struct Archive {
  explicit Archive(SessionStoreSettings settings) : sessions(std::move(settings)) {}

  SessionStore sessions;
  PhotographStore photographs;
  /// The report that was made last, and of which session in which state.
  std::mutex report_mutex{};
  std::string report_of{};
  std::shared_ptr<const std::string> report_html{};
};

void add_archive_routes(Router& router, Archive& archive);

/// What `strobe report SESSION` writes without options.
std::string session_report_html(const host::StoredSession& session, const std::string& version);

/// A route of a shot, of which the name may have two parts ("3/1f2e4d"): rest is "" or "/photograph".
void add_shot_route(Router& router, const std::string& method, const std::string& rest,
                    Router::Handler handler);
/// What {session} and {shot} matched.
std::string session_of(const Request& request);
std::string shot_of(const Request& request);

/// detail_json() of the shot.
nlohmann::ordered_json shot_detail(Archive& archive, const std::string& session, const ShotOfSession& shot);
/// Where its photograph is to be had; absent: it cannot be shown.
std::optional<PhotographPlace> photograph_place(Archive& archive, const std::string& session,
                                                const host::Shot& shot);

}  // namespace strobe::web
