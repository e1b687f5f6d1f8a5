#include "host/web/archive_routes.hpp"

#include <fmt/format.h>
#include <glib.h>
#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "host/config/notes.hpp"
#include "host/report/report.hpp"
#include "host/series/compare.hpp"
#include "host/view/series_json.hpp"
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

Response show_series(Archive& archive, const Request& request) {
  const std::string id = session_of(request);
  const Chosen chosen{asked(request, "spin"), asked(request, "angle")};
  auto rows = archive.sessions.rows(id);
  if (!rows) return error_response(rows.error());
  std::erase_if(*rows, [&](const ShotRow& row) { return !chosen.has(row.spin, row.angle_deg); });
  const auto shots = archive.sessions.series_shots(id);
  if (!shots) return error_response(shots.error());
  host::Series series;
  for (const host::Shot& shot : *shots) {
    const auto& record = shot.readout.record;
    const auto spin = record.find("spin");
    if (chosen.has(spin == record.end() ? "" : spin->second, host::note_number(record, "angle_deg")))
      series.add(shot);
  }
  return json_response(series_page_json(series.summary(id), condition_of(*rows), *rows));
}

Response compare_sessions(Archive& archive, const Request& request) {
  std::array<host::Series, 2> series;
  const std::array<std::string, 2> ids{asked(request, "first"), asked(request, "second")};
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto shots = archive.sessions.series_shots(ids[i]);
    if (!shots) return error_response(shots.error());
    for (host::Shot shot : *shots) {
      shot.session = ids[i];
      series[i].add(shot);
    }
  }
  ordered_json object = host::comparison_json(ids[0], ids[1], host::compare(series[0], series[1]));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const host::SeriesSummary summary = series[i].summary(ids[i]);
    object["series"].push_back(host::series_json(summary, std::nullopt));
    object["n"].push_back(summary.counted);
  }
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
