#include "host/web/live_shots.hpp"

#include <algorithm>

#include "host/archive/session_files.hpp"

namespace strobe::web {

void LiveShots::on_shot_result(const host::Shot& shot) {
  if (shot.dry || !own_(shot.host_id)) return;
  host::Shot copy = shot;
  const std::lock_guard lock(mutex_);
  std::erase_if(newest_, [&](const host::Shot& known) { return known.key() == copy.key(); });
  if (newest_.size() == kMaxKept) newest_.pop_front();
  newest_.push_back(std::move(copy));
}

std::optional<host::Shot> LiveShots::find(const ShotKey& key) const {
  std::optional<host::Shot> shot;
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(newest_, key, &host::Shot::key);
    if (found == newest_.end()) return std::nullopt;
    shot = *found;
  }
  shot->rig = rig_;
  shot->budget = {};
  if (const auto* frame = shot->frame())
    shot->photograph = host::named_photograph(folder_, frame->photograph);
  return shot;
}

std::optional<ShotKey> LiveShots::newest_numbered(int shot_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(newest_.rbegin(), newest_.rend(),
                                  [shot_id](const host::Shot& shot) { return shot.shot_id == shot_id; });
  return found == newest_.rend() ? std::nullopt : std::optional(found->key());
}

}  // namespace strobe::web
