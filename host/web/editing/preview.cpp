#include "host/web/editing/preview.hpp"

#include <utility>

#include "host/archive/redigitize.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/assembly/camera_map.hpp"
#include "host/photographs/digitization_json.hpp"

namespace strobe::web {
namespace {

using host::Shot;
using host::StoredSession;

/// By way of the text that a session keeps, so that not a bit differs from what saving gives.
Answered<Preview> with_result(Preview preview, const host::RigFile& rig) {
  preview.found.frame.map_errors = host::map_errors(rig.camera, preview.found.frame);
  const std::string text = host::digitization_json(
      preview.found, preview.shot.photograph->filename().string(), preview.settings, false);
  auto digitization = host::parse_digitization(text, preview.shot.key(), "these corrections");
  if (!digitization) return unanswered(422, digitization.error().message);
  preview.shot.digitizations.push_back(std::move(*digitization));
  host::judge_again(preview.shot);
  return preview;
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
  Measured measured{std::move(made->found), std::move(made->settings), made->photograph.width(),
                    made->photograph.height()};
  return kept_.put(std::move(key), std::move(measured), 1);
}

Answered<Preview> Previewer::automatic(const StoredSession& session, const Shot& shot) {
  auto known = measured(session, shot);
  if (!known) return tl::unexpected(known.error());
  return with_result(
      {shot, std::move(known->found), std::move(known->settings), known->width_px, known->height_px},
      *shot.rig);
}

Answered<Preview> Previewer::preview(const StoredSession& session, const Shot& shot,
                                     const std::string& corrections, const std::string& file_name) {
  const auto read = digitize::parse_corrections(corrections, file_name);
  if (!read) return unanswered(422, read.error().message);
  auto known = measured(session, shot);
  if (!known) return tl::unexpected(known.error());
  if (auto applied = digitize::apply_corrections(known->found, *read, known->settings); !applied)
    return unanswered(422, applied.error().message);
  return with_result(
      {shot, std::move(known->found), std::move(known->settings), known->width_px, known->height_px},
      *shot.rig);
}

}  // namespace strobe::web
