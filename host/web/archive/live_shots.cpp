#include "host/web/archive/live_shots.hpp"

#include <algorithm>

#include "host/archive/photograph_files.hpp"

namespace strobe::web {

LiveShots::Heard& LiveShots::heard_of(const ShotKey& key) {
  const auto found = std::ranges::find(newest_, key, &Heard::key);
  if (found != newest_.end()) return *found;
  if (newest_.size() == kMaxKept) newest_.pop_front();
  return newest_.emplace_back(Heard{key, {}, {}});
}

void LiveShots::on_shot(const strobe_msgs::shot_t& shot) {
  if (shot.plan.dry || !own_(shot.host_id)) return;
  {
    const std::lock_guard lock(mutex_);
    if (heard_of({shot.boot_id, shot.shot_id}).summary) return;  // it comes more than once
  }
  auto copy = std::optional(shot);
  const std::lock_guard lock(mutex_);
  heard_of({shot.boot_id, shot.shot_id}).summary.swap(copy);
}

void LiveShots::on_shot_result(const host::ShotResult& result) {
  if (result.dry || !own_(result.host_id)) return;
  auto copy = std::optional(result);
  const std::lock_guard lock(mutex_);
  heard_of({result.boot_id, result.shot_id}).result.swap(copy);
}

std::optional<host::StoredShot> LiveShots::find(const ShotKey& key) const {
  host::StoredShot shot;
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(newest_, key, &Heard::key);
    if (found == newest_.end() || !found->result) return std::nullopt;
    shot.summary = found->summary;
    shot.result = *found->result;
  }
  shot.key = key;
  shot.rig = rig_;
  shot.result.assembled.reset();
  shot.result.budget.reset();
  if (!shot.result.frame) return shot;
  shot.digitizations.push_back({*shot.result.frame, shot.result.frame->source == "hand", "", "", {}, {}});
  shot.photograph = host::named_photograph(folder_, shot.result.frame->photograph);
  return shot;
}

std::optional<ShotKey> LiveShots::newest_numbered(int shot_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(newest_.rbegin(), newest_.rend(), [shot_id](const Heard& heard) {
    return heard.key.shot_id == shot_id && heard.result;
  });
  return found == newest_.rend() ? std::nullopt : std::optional(found->key);
}

}  // namespace strobe::web
