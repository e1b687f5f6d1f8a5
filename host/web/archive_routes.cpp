#include "host/web/archive_routes.hpp"

#include <fmt/format.h>
#include <glib.h>
#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "host/config/notes.hpp"
#include "host/report/report.hpp"
#include "host/series/compare.hpp"
#include "host/view/drift_view.hpp"
#include "host/view/series_json.hpp"
#include "host/web/conditions.hpp"
#include "host/web/detail_json.hpp"
#include "host/web/shot_json.hpp"

namespace strobe::web {
namespace {

using nlohmann::ordered_json;

std::string asked(const Request& request, const char* name) {
  const auto found = request.query.find(name);
  return found == request.query.end() ? std::string() : found->second;
}

std::optional<int> asked_number(const Request& request, const char* name) {
  const std::string text = asked(request, name);
  int number = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  return read.ec == std::errc() && read.ptr == end ? std::optional(number) : std::nullopt;
}

/// One part of a path.
std::string escaped_part(const std::string& text) {
  const std::unique_ptr<char, decltype(&g_free)> escaped(g_uri_escape_string(text.c_str(), nullptr, false),
                                                         g_free);
  return escaped.get();
}

Response list_sessions(Archive& archive) { return json_response(archive.sessions.list()); }

constexpr int kDefaultShots = 100, kMaxShots = 2000;

Response list_shots(Archive& archive, const Request& request) {
  const auto rows = archive.sessions.rows(session_of(request));
  if (!rows) return error_response(rows.error());
  const int limit = std::clamp(asked_number(request, "limit").value_or(kDefaultShots), 1, kMaxShots);
  auto end = rows->end();
  if (const std::string before = asked(request, "before"); !before.empty()) {
    end = std::ranges::find(*rows, before, &ShotRow::name);
    if (end == rows->end()) return error_response(404, "the session has no shot of this name");
  }
  const auto begin = end - std::min<std::ptrdiff_t>(limit, end - rows->begin());
  ordered_json shots = ordered_json::array();
  for (auto row = end; row != begin; --row) shots.push_back(shot_json(*std::prev(row), session_of(request)));
  return json_response({{"shots", std::move(shots)}, {"more", begin != rows->begin()}});
}

Response show_shot(Archive& archive, const Request& request) {
  const auto shot = archive.sessions.shot(session_of(request), shot_of(request));
  if (!shot) return error_response(shot.error());
  return json_response(shot_detail(archive, session_of(request), *shot));
}

Response show_photograph(Archive& archive, const Request& request) {
  const auto shot = archive.sessions.shot(session_of(request), shot_of(request));
  if (!shot) return error_response(shot.error());
  if (!shot->shot->photograph) return error_response(404, "the shot has no photograph in the session");
  const auto folder = archive.sessions.folder(session_of(request));
  if (!folder) return error_response(folder.error());
  const auto picture = archive.photographs.picture(*folder, *shot->shot->photograph,
                                                   asked_number(request, "width").value_or(0));
  if (!picture) return error_response(picture.error());
  Response response;
  response.type = "image/jpeg";
  response.body = picture->jpeg;
  response.etag = picture->tag;
  return response;
}

/// Shots of this spin and angle; empty: any.
struct Chosen {
  std::string spin, angle;
  bool has(const std::string& its_spin, const std::optional<double>& its_angle) const {
    if (!spin.empty() && spin != its_spin) return false;
    if (angle.empty()) return true;
    const auto wanted = host::note_number({{"angle", angle}}, "angle");
    return wanted && its_angle && *wanted == *its_angle;
  }
};

/// Of a session, or of its shots that are like one of them.
Answered<std::vector<host::ShotGroup>> conditions(Archive& archive, const std::string& id,
                                                  const std::string& like, const Chosen& chosen = {},
                                                  const std::vector<std::string>& over = {}) {
  auto shots = archive.sessions.series_shots(id);
  if (!shots) return tl::unexpected(shots.error());
  std::erase_if(*shots, [&](const host::Shot& shot) {
    return !chosen.has(host::value_of(shot, "spin"), host::note_number(shot.readout.record, "angle_deg"));
  });
  auto groups = conditions_of(std::move(*shots), like, over);
  if (!groups) return unanswered(404, groups.error().message);
  return std::move(*groups);
}

std::vector<std::string> words_between_commas(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  return words;
}

host::Series series_of(const std::vector<host::ShotGroup>& groups) {
  host::Series series;
  for (const host::ShotGroup& group : groups)
    for (const host::Shot& shot : group.shots) series.add(shot);
  return series;
}

/// Lines for a person, of all that is shown together.
std::vector<std::string> drift_of(const std::vector<host::ShotGroup>& groups) {
  std::vector<host::Shot> shots;
  for (const host::ShotGroup& group : groups)
    shots.insert(shots.end(), group.shots.begin(), group.shots.end());
  return host::render_drift(host::charts_of(shots));
}

/// Of rows, those of the groups' shots.
void keep_rows_of(const std::vector<host::ShotGroup>& groups, std::vector<ShotRow>& rows) {
  std::set<ShotKey> keys;
  for (const host::ShotGroup& group : groups)
    for (const host::Shot& shot : group.shots) keys.insert(shot.key());
  std::erase_if(rows, [&](const ShotRow& row) { return !keys.contains(row.key); });
}

Response show_series(Archive& archive, const Request& request) {
  const std::string id = session_of(request), like = asked(request, "like");
  const Chosen chosen{asked(request, "spin"), asked(request, "angle")};
  auto rows = archive.sessions.rows(id);
  if (!rows) return error_response(rows.error());
  std::erase_if(*rows, [&](const ShotRow& row) { return !chosen.has(row.spin, row.angle_deg); });
  const auto groups = conditions(archive, id, like, chosen, words_between_commas(asked(request, "over")));
  if (!groups) return error_response(groups.error());
  if (!like.empty()) keep_rows_of(*groups, *rows);
  const std::vector<std::string> differ = differences(*groups);
  ordered_json page{
      {"summary", nullptr}, {"points", ordered_json::array()}, {"limits", nullptr}, {"thesis", nullptr}};
  if (!is_mixture(*groups)) {
    page = series_page_json(series_of(*groups).summary(id), condition_of(*rows), *rows);
    page["drift"] = drift_of(*groups);
    for (const auto& sentence : page["summary"]["alignment"]) page["drift"].push_back(sentence);
  }
  page["conditions"] = conditions_json(*groups, differ);
  page["differ"] = differ;
  return json_response(page);
}

Response compare_sessions(Archive& archive, const Request& request) {
  std::array<std::vector<host::ShotGroup>, 2> groups;
  const std::array<std::string, 2> ids{asked(request, "first"), asked(request, "second")};
  const std::array<const char*, 2> like{"first_like", "second_like"};
  for (std::size_t i = 0; i < ids.size(); ++i) {
    auto of_session = conditions(archive, ids[i], asked(request, like[i]));
    if (!of_session) return error_response(of_session.error());
    groups[i] = std::move(*of_session);
  }
  const std::array series{series_of(groups[0]), series_of(groups[1])};
  std::vector<host::ShotGroup> both = groups[0];
  both.insert(both.end(), groups[1].begin(), groups[1].end());
  const std::vector<std::string> differ = differences(both);
  const bool mixed = is_mixture(groups[0]) || is_mixture(groups[1]);
  ordered_json object{{"compare", ids}, {"quantities", nullptr}};
  if (!mixed) object = host::comparison_json(ids[0], ids[1], host::compare(series[0], series[1]));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const host::SeriesSummary summary = series[i].summary(ids[i]);
    object["series"].push_back(mixed ? ordered_json() : host::series_json(summary, std::nullopt));
    object["n"].push_back(summary.counted);
    object["conditions"].push_back(conditions_json(groups[i], differ));
  }
  object["differ"] = differ;
  return json_response(object);
}

constexpr const char* kReportPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'";

Response show_report(Archive& archive, const Request& request) {
  const std::string id = session_of(request);
  const auto state = archive.sessions.state(id);
  if (!state) return error_response(state.error());
  const auto session = archive.sessions.stored(id);
  if (!session) return error_response(session.error());
  const std::lock_guard lock(archive.report_mutex);
  if (const std::string of = id + " " + *state; archive.report_of != of) {
    archive.report_html = std::make_shared<const std::string>(
        session_report_html(**session, archive.sessions.settings().version));
    archive.report_of = of;
  }
  return {.type = "text/html; charset=utf-8", .body = archive.report_html, .policy = kReportPolicy};
}

}  // namespace

std::string session_report_html(const host::StoredSession& session, const std::string& version) {
  report::ReportInput input;
  input.version = version;
  input.sessions.push_back(session);
  return report::render_html(report::build_report(input));
}

std::string session_of(const Request& request) { return request.parameters.at("session"); }

std::string shot_of(const Request& request) {
  const auto boot = request.parameters.find("boot");
  return request.parameters.at("shot") + (boot == request.parameters.end() ? "" : "/" + boot->second);
}

void add_shot_route(Router& router, const std::string& method, const std::string& rest,
                    Router::Handler handler) {
  for (const char* shot : {"{shot}", "{shot}/{boot}"}) {
    const std::string pattern = std::string("/api/v1/sessions/{session}/shots/") + shot + rest;
    if (method == "POST")
      router.post(pattern, Work::slow, handler);
    else
      router.get(pattern, Work::slow, handler);
  }
}

std::optional<PhotographPlace> photograph_place(Archive& archive, const std::string& session,
                                                const host::Shot& shot) {
  if (!shot.photograph) return std::nullopt;
  const auto folder = archive.sessions.folder(session);
  if (!folder) return std::nullopt;
  const auto size = archive.photographs.size(*folder, *shot.photograph);
  if (!size) return std::nullopt;
  return PhotographPlace{
      fmt::format("/api/v1/sessions/{}/shots/{}/photograph", escaped_part(session), escaped_part(shot.name)),
      size->width_px, size->height_px};
}

ordered_json shot_detail(Archive& archive, const std::string& session, const ShotOfSession& shot) {
  return detail_json(*shot.shot, session, photograph_place(archive, session, *shot.shot));
}

void add_archive_routes(Router& router, Archive& archive) {
  const auto add = [&](const char* pattern, Response (*answer)(Archive&, const Request&)) {
    router.get(pattern, Work::slow,
               [&archive, answer](const Request& request) { return answer(archive, request); });
  };
  router.get("/api/v1/quantities", Work::quick,
             [](const Request&) { return json_response(quantities_json()); });
  router.get("/api/v1/sessions", Work::slow, [&archive](const Request&) { return list_sessions(archive); });
  add("/api/v1/sessions/{session}/shots", list_shots);
  add("/api/v1/sessions/{session}/series", show_series);
  router.get("/api/v1/sessions/{session}/report", Work::lasts,
             [&archive](const Request& request) { return show_report(archive, request); });
  add("/api/v1/compare", compare_sessions);
  const auto of_shot = [&](const char* rest, Response (*answer)(Archive&, const Request&)) {
    add_shot_route(router, "GET", rest,
                   [&archive, answer](const Request& request) { return answer(archive, request); });
  };
  of_shot("/photograph", show_photograph);
  of_shot("", show_shot);
}

}  // namespace strobe::web
