#include "host/web/editing.hpp"

#include <chrono>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "common/config/files.hpp"
#include "common/config/toml_bounds.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/archive/redigitize.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/assembly/camera_map.hpp"
#include "host/light/advice.hpp"
#include "host/photographs/digitization_json.hpp"
#include "host/session/advice.hpp"
#include "host/web/images_json.hpp"
#include "host/web/shot_json.hpp"

namespace strobe::web {
namespace {

namespace fs = std::filesystem;
using host::Shot;
using host::StoredSession;
using messages::or_null;
using nlohmann::ordered_json;

/// By way of the text that a session keeps, so that not a bit differs from what saving gives.
Answered<Preview> with_result(Preview preview) {
  host::set_calibration(preview.shot.rig->camera, preview.found.frame);
  const std::string text = host::digitization_json(
      preview.found, preview.shot.photograph->filename().string(), preview.settings, false);
  auto digitization = host::parse_digitization(text, preview.shot.key(), "these corrections");
  if (!digitization) return unanswered(422, digitization.error().message);
  preview.shot.digitizations.push_back(std::move(*digitization));
  host::judge_again(preview.shot);
  return preview;
}

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
  const ShotRow row = shot_row(result);
  return values_json(row.value, row.total_sd);
}

/// What is measured on the photograph.
ordered_json photograph_json(const Preview& seen) {
  const auto& frame = seen.shot.digitizations.back().frame;
  const digitize::PlaneMap& map = seen.settings.map;
  return {{"images", images_json(seen.shot.summary ? &*seen.shot.summary : nullptr, frame,
                                 host::assembly_settings(*seen.shot.rig), map)},
          {"unmeasured", unmeasured_json(seen.found.unmeasured, map)},
          {"surface_px", surface_json(frame, map)}};
}

ordered_json preview_json(const Shot& before, const Preview& after) {
  const Shot& result = after.shot;
  ordered_json json{{"before", result_values(before)},
                    {"after", result_values(result)},
                    {"rejected", {{"before", or_null(before.rejected)}, {"after", or_null(result.rejected)}}},
                    {"flags", shot_row(result).flags},
                    {"advice", host::advice(result)}};
  json.update(photograph_json(after));
  json["surface_by_hand"] = after.found.surface_by_hand;
  json["problem"] = result.problem.empty() ? ordered_json() : ordered_json(result.problem);
  return json;
}

Response preview_corrections(Editing& editing, const Request& request) {
  const auto begun = std::chrono::steady_clock::now();
  const auto text = corrections_in(request);
  if (!text) return error_response(text.error());
  const auto shot = editing.archive.sessions.stored_shot(session_of(request), shot_of(request));
  if (!shot) return error_response(shot.error());
  const auto preview = editing.previews.preview(*shot->session, *shot->shot, *text, kCorrectionsName);
  ordered_json object;
  if (preview) {
    object = preview_json(*shot->shot, *preview);
  } else if (preview.error().status == 422) {  // a person is still typing
    object = {{"before", result_values(*shot->shot)}, {"after", nullptr}, {"problem", preview.error().words}};
  } else {
    return error_response(preview.error());
  }
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begun;
  object["took_ms"] = taken.count();
  return json_response(object);
}

/// What the automatic digitizer left out on the photograph, and why.
Response show_unmeasured(Editing& editing, const Request& request) {
  const auto shot = editing.archive.sessions.stored_shot(session_of(request), shot_of(request));
  if (!shot) return error_response(shot.error());
  const auto found = editing.previews.automatic(*shot->session, *shot->shot);
  if (!found) return error_response(found.error());
  return json_response({{"unmeasured", unmeasured_json(found->found.unmeasured, found->settings.map)},
                        {"remarks", found->found.remarks},
                        {"light", found->light}});
}

/// The corrections that count, as a list; empty: none do.
Answered<ordered_json> counting_corrections(const Shot& shot, const digitize::PlaneMap& map) {
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
  if (!shot) return error_response(shot.error());
  const auto found = editing.previews.automatic(*shot->session, *shot->shot);
  if (!found) return error_response(found.error());
  const auto corrections = counting_corrections(*shot->shot, found->settings.map);
  if (!corrections) return error_response(corrections.error());
  return json_response({{"found", photograph_json(*found)}, {"corrections", *corrections}});
}

using Change = std::function<Result<host::ChangedShot>(const StoredSession&, const Shot&)>;

Response change_shot(Editing& editing, const Request& request, const Change& change) {
  const std::lock_guard lock(editing.changing);
  const std::string session = session_of(request), name = shot_of(request);
  const auto shot = editing.archive.sessions.stored_shot(session, name);
  if (!shot) return error_response(shot.error());
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
  if (!now) return error_response(now.error());
  return json_response(
      {{"changed", changed->changed}, {"shot", shot_detail(editing.archive, session, *now)}});
}

Response save_corrections(Editing& editing, const Request& request) {
  const auto text = corrections_in(request);
  if (!text) return error_response(text.error());
  return change_shot(editing, request, [&](const StoredSession& session, const Shot& shot) {
    return host::put_correction(session, shot, *text, kCorrectionsName, editing.author());
  });
}

Response undo_corrections(Editing& editing, const Request& request) {
  return change_shot(editing, request, [](const StoredSession& session, const Shot& shot) {
    return host::take_back(session, shot);
  });
}

}  // namespace

Answered<Previewer::Measured> Previewer::measured(const StoredSession& session, const Shot& shot) {
  if (!shot.photograph) return unanswered(409, "the shot has no photograph in the session");
  if (!is_own_file(session.folder, *shot.photograph))
    return unanswered(409, "the photograph is no file of the session");
  Key key{*shot.photograph, stamp_of(*shot.photograph), shot.key()};
  const std::lock_guard lock(mutex_);
  if (const Measured* known = kept_.find(key)) return *known;
  auto made = host::redigitize(session, shot);
  if (!made) return unanswered(409, made.error().message);
  const auto measures = light::measure_light(made->photograph, made->settings.map, made->found);
  return kept_.put(
      std::move(key),
      Measured{std::move(made->found), std::move(made->settings), light::in_short(light::advise(measures))},
      1);
}

Answered<Preview> Previewer::automatic(const StoredSession& session, const Shot& shot) {
  auto known = measured(session, shot);
  if (!known) return tl::unexpected(known.error());
  return with_result({shot, std::move(known->found), std::move(known->settings), std::move(known->light)});
}

Answered<Preview> Previewer::preview(const StoredSession& session, const Shot& shot,
                                     const std::string& corrections, const std::string& file_name) {
  const auto read = digitize::parse_corrections(corrections, file_name);
  if (!read) return unanswered(422, read.error().message);
  auto known = measured(session, shot);
  if (!known) return tl::unexpected(known.error());
  if (auto applied = digitize::apply_corrections(known->found, *read, known->settings); !applied)
    return unanswered(422, applied.error().message);
  return with_result({shot, std::move(known->found), std::move(known->settings), std::move(known->light)});
}

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
