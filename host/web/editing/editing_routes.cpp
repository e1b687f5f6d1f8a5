#include "host/web/editing/editing_routes.hpp"

#include <chrono>
#include <nlohmann/json.hpp>
#include <system_error>

#include "common/config/files.hpp"
#include "common/config/toml_bounds.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/web/json/advice.hpp"
#include "host/web/json/corrections_json.hpp"
#include "host/web/json/images_json.hpp"

namespace strobe::web {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// For messages: the text came without a file.
constexpr const char* kCorrectionsName = "corrections.toml";

Answered<std::string> corrections_in(const Request& request) {
  const ordered_json body = messages::parsed_json<ordered_json>(request.body);
  const auto found = body.is_object() ? body.find("corrections") : body.end();
  if (!body.is_object() || found == body.end() || !found->is_string())
    return unanswered(400, "the body must be {\"corrections\":\"TOML\"}");
  std::string text = found->get<std::string>();
  if (const auto problem = config::toml_bounds_problem(text))
    return unanswered(400, std::string(kCorrectionsName) + ":" + problem->message);
  return text;
}

ordered_json result_values(const host::Shot& result) {
  const ShotRow row = shot_row(result, "", "", "");
  return values_json(row.value, row.total_sd);
}

ordered_json rejected_json(const host::Shot& result) {
  return result.rejected ? ordered_json(*result.rejected) : ordered_json();
}

ordered_json preview_json(const host::Shot& before, const Preview& after) {
  const auto& frame = after.shot.digitizations.back().frame;
  const digitize::PlaneMap& map = after.settings.map;
  const ShotRow row = shot_row(after.shot, after.shot.name, "", "corrected");
  return {{"before", result_values(before)},
          {"after", result_values(after.shot)},
          {"rejected", {{"before", rejected_json(before)}, {"after", rejected_json(after.shot)}}},
          {"flags", row.flags},
          {"advice", advice(after.shot)},
          {"images", images_json(after.shot.summary ? &*after.shot.summary : nullptr, frame,
                                 host::assembly_settings(*after.shot.rig), map)},
          {"unmeasured", unmeasured_json(after.found.unmeasured, map)},
          {"surface_px", surface_json(frame, map)},
          {"surface_by_hand", after.found.surface_by_hand},
          {"problem", after.shot.problem.empty() ? ordered_json() : ordered_json(after.shot.problem)}};
}

Response preview_corrections(Editing& editing, const Request& request) {
  const auto begun = std::chrono::steady_clock::now();
  const auto text = corrections_in(request);
  if (!text) return unanswered_response(text.error());
  const auto shot = editing.archive.sessions.stored_shot(session_of(request), shot_of(request));
  if (!shot) return unanswered_response(shot.error());
  const auto preview = editing.previews.preview(*shot->session, *shot->shot, *text, kCorrectionsName);
  ordered_json object;
  if (preview) {
    object = preview_json(*shot->shot, *preview);
  } else if (preview.error().status == 422) {  // a person is still typing
    object = {{"before", result_values(*shot->shot)}, {"after", nullptr}, {"problem", preview.error().words}};
  } else {
    return unanswered_response(preview.error());
  }
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begun;
  object["took_ms"] = taken.count();
  return json_response(object);
}

/// What the automatic digitizer left out on the photograph, and why.
Response show_unmeasured(Editing& editing, const Request& request) {
  const auto shot = editing.archive.sessions.stored_shot(session_of(request), shot_of(request));
  if (!shot) return unanswered_response(shot.error());
  const auto found = editing.previews.automatic(*shot->session, *shot->shot);
  if (!found) return unanswered_response(found.error());
  return json_response({{"unmeasured", unmeasured_json(found->found.unmeasured, found->settings.map)},
                        {"remarks", found->found.remarks}});
}

/// The corrections that count, as a list; empty: none do.
Answered<ordered_json> counting_corrections(const host::Shot& shot, const digitize::PlaneMap& map) {
  if (shot.digitizations.empty() || shot.digitizations.back().corrections.empty())
    return ordered_json::array();
  const std::string file = shot.digitizations.back().corrections.string();
  const auto text = config::read_file(file);
  if (!text) return unanswered(409, text.error().message);
  const auto corrections = digitize::parse_corrections(*text, file);
  if (!corrections) return unanswered(409, corrections.error().message);
  return corrections_json(*corrections, map);
}

/// What an editor begins with: what was found, which corrections refer to, and those that count.
Response show_corrections(Editing& editing, const Request& request) {
  const auto shot = editing.archive.sessions.stored_shot(session_of(request), shot_of(request));
  if (!shot) return unanswered_response(shot.error());
  const auto found = editing.previews.automatic(*shot->session, *shot->shot);
  if (!found) return unanswered_response(found.error());
  const auto corrections = counting_corrections(*shot->shot, found->settings.map);
  if (!corrections) return unanswered_response(corrections.error());
  const ordered_json seen = preview_json(*shot->shot, *found);
  return json_response(
      {{"found",
        {{"images", seen["images"]}, {"unmeasured", seen["unmeasured"]}, {"surface_px", seen["surface_px"]}}},
       {"corrections", *corrections}});
}

using Change = std::function<Result<host::ChangedShot>(const host::StoredSession&, const host::Shot&)>;

Response change_shot(Editing& editing, const Request& request, const Change& change) {
  const std::lock_guard lock(editing.changing);
  const std::string session = session_of(request), name = shot_of(request);
  const auto shot = editing.archive.sessions.stored_shot(session, name);
  if (!shot) return unanswered_response(shot.error());
  std::error_code error;
  if (fs::is_symlink(fs::symlink_status(shot->session->folder / "digitizations", error)))
    return error_response(409,
                          "the session's digitizations lie elsewhere: correct them with strobe shot --edit");
  const auto changed = change(*shot->session, *shot->shot);
  if (!changed) return error_response(422, changed.error().message);
  if (changed->changed) {
    editing.archive.sessions.take_change(session, changed->shot);
    editing.hub.publish("edited", messages::json_text(ordered_json{{"session", session}, {"shot", name}}));
  }
  const auto now = editing.archive.sessions.stored_shot(session, name);
  if (!now) return unanswered_response(now.error());
  const auto detail = shot_detail(editing.archive, session, *now);
  if (!detail) return unanswered_response(detail.error());
  return json_response({{"changed", changed->changed}, {"shot", *detail}});
}

Response save_corrections(Editing& editing, const Request& request) {
  const auto text = corrections_in(request);
  if (!text) return unanswered_response(text.error());
  return change_shot(editing, request, [&](const host::StoredSession& session, const host::Shot& shot) {
    return host::put_correction(session, shot, *text, kCorrectionsName, editing.author());
  });
}

Response undo_corrections(Editing& editing, const Request& request) {
  return change_shot(editing, request, [](const host::StoredSession& session, const host::Shot& shot) {
    return host::take_back(session, shot);
  });
}

}  // namespace

void add_editing_routes(Router& router, Editing& editing) {
  const auto add = [&](const char* method, const char* rest, Response (*answer)(Editing&, const Request&)) {
    add_shot_route(router, method, rest,
                   [&editing, answer](const Request& request) { return answer(editing, request); });
  };
  add("GET", "/unmeasured", show_unmeasured);
  add("GET", "/corrections", show_corrections);
  add("POST", "/preview", preview_corrections);
  add("POST", "/corrections", save_corrections);
  add("POST", "/undo", undo_corrections);
}

}  // namespace strobe::web
