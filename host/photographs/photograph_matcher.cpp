#include "host/photographs/photograph_matcher.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace strobe::host {
namespace {

using strobe_msgs::shot_t;

constexpr std::int64_t kSecond_ns = 1'000'000'000;
// The firmware's clock is known here but for the time that a message takes, and to far less than that later
// on.
constexpr std::int64_t kClockDoubt_ns = kSecond_ns / 10;
// Some file systems keep times to two seconds.
constexpr std::int64_t kFileTimeDoubt_ns = 2 * kSecond_ns;
// Longest that a photograph waits for word of its shot, which may have to be asked for again.
constexpr std::int64_t kClaim_ns = 5 * kSecond_ns;
// Longest after a shot that a photograph may still be its.
constexpr std::int64_t kForgotten_ns = 60 * kSecond_ns;
constexpr std::size_t kMaxExposures = 200;

}  // namespace

void PhotographMatcher::on_shot(const shot_t& shot) {
  const ShotKey key{shot.boot_id, shot.shot_id};
  const bool known = std::any_of(exposures_.begin(), exposures_.end(),
                                 [&](const Exposure& exposure) { return exposure.key == key; });
  if (known || shot.shutter_open_ns == shot_t::NO_TIME || shot.shutter_open_ns == 0) return;
  const std::int64_t closed = std::max(shot.shutter_close_ns, shot.shutter_open_ns);
  const Exposure exposure{key, shot.shutter_open_ns, closed, !shot.plan.dry, false};
  const auto later = std::find_if(exposures_.begin(), exposures_.end(),
                                  [&](const Exposure& other) { return other.closed_ns > closed; });
  exposures_.insert(later, exposure);
  if (exposures_.size() > kMaxExposures) exposures_.erase(exposures_.begin());
}

void PhotographMatcher::on_measured(const ShotKey& shot) {
  for (Exposure& exposure : exposures_) {
    if (exposure.key == shot) exposure.wanted = false;
  }
}

void PhotographMatcher::give_back(const ShotKey& shot) {
  for (Exposure& exposure : exposures_) {
    if (exposure.key == shot) exposure.taken = false;
  }
}

void PhotographMatcher::on_photograph(int photograph, std::int64_t arrived_ns, std::int64_t written_ns) {
  held_.push_back({photograph, arrived_ns, written_ns});
}

/// Shots before one that has its photograph get none any more.
PhotographMatcher::Candidates PhotographMatcher::candidates(const Held& held, std::int64_t now_ns) const {
  Candidates result;
  for (std::size_t i = exposures_.size(); i-- > 0 && !exposures_[i].taken;) {
    const Exposure& exposure = exposures_[i];
    const std::int64_t closed = local(exposure.closed_ns);
    if (held.arrived_ns < closed - kClockDoubt_ns || held.arrived_ns > closed + kForgotten_ns) continue;
    if (held.written_ns < local(exposure.opened_ns) - kFileTimeDoubt_ns) continue;
    auto& list = now_ns <= closed + timeout_ns_ ? result.waiting : result.given_up;
    list.insert(list.begin(), i);
  }
  return result;
}

/// When the photograph of an exposure should have come, as far as earlier ones tell.
std::int64_t PhotographMatcher::own_due_ns(const Exposure& exposure) const {
  const std::int64_t usual = usual_ns_ ? 2 * *usual_ns_ + kSecond_ns / 5 : timeout_ns_ / 2;
  return local(exposure.closed_ns) + std::min(usual, timeout_ns_ / 5 * 4);
}

PhotographDecision PhotographMatcher::take(std::size_t i, std::int64_t now_ns, bool certain) {
  Exposure& exposure = exposures_[i];
  const Held held = held_.front();
  held_.erase(held_.begin());
  exposure.taken = true;
  const std::int64_t closed = local(exposure.closed_ns);
  if (certain) usual_ns_ = std::max(usual_ns_.value_or(0), held.arrived_ns - closed);
  PhotographDecision decision;
  decision.photograph = held.photograph;
  decision.shot = exposure.key;
  decision.wanted = exposure.wanted;
  decision.late = now_ns > closed + timeout_ns_;
  return decision;
}

PhotographDecision PhotographMatcher::reject(std::string why) {
  PhotographDecision decision;
  decision.photograph = held_.front().photograph;
  decision.why = std::move(why);
  held_.erase(held_.begin());
  return decision;
}

std::string PhotographMatcher::nobody(const Held& held) const {
  for (const Exposure& exposure : exposures_) {
    const std::int64_t closed = local(exposure.closed_ns);
    const bool in_time =
        held.arrived_ns >= closed - kClockDoubt_ns && held.arrived_ns <= closed + timeout_ns_;
    const std::int64_t before_ns = local(exposure.opened_ns) - held.written_ns;
    if (in_time && !exposure.taken && before_ns > kFileTimeDoubt_ns) {
      return fmt::format("its file is {:.1f} s older than shot {}: not used",
                         static_cast<double>(before_ns) * 1e-9, exposure.key.shot_id);
    }
  }
  return "no shot waits for a photograph: not used";
}

/// Several shots may be meant.
std::optional<PhotographDecision> PhotographMatcher::choose(const Candidates& candidates,
                                                            std::int64_t now_ns) {
  const auto& [waiting, given_up] = candidates;
  const std::size_t oldest = given_up.empty() ? waiting.front() : given_up.front();
  if (held_.size() >= candidates.count()) return take(oldest, now_ns, false);
  if (waiting.empty()) {
    return reject(fmt::format("it came too late, of shot {} or {}: not used",
                              exposures_[given_up.front()].key.shot_id,
                              exposures_[given_up.back()].key.shot_id));
  }
  if (waiting.size() > 1) return std::nullopt;
  if (held_.size() > 1) {
    return reject(fmt::format("it came too late, of one of the shots before {}: not used",
                              exposures_[waiting.front()].key.shot_id));
  }
  // If the one before the newest had come late, the newest shot's own would follow by then.
  if (now_ns < own_due_ns(exposures_[waiting.front()])) return std::nullopt;
  return take(waiting.front(), now_ns, false);
}

std::optional<PhotographDecision> PhotographMatcher::decide_first(std::int64_t now_ns) {
  const Candidates found = candidates(held_.front(), now_ns);
  if (found.count() > 1) return choose(found, now_ns);
  if (found.count() == 1)
    return take(found.waiting.empty() ? found.given_up[0] : found.waiting[0], now_ns, true);
  if (now_ns - held_.front().arrived_ns < kClaim_ns) return std::nullopt;
  return reject(nobody(held_.front()));
}

std::vector<PhotographDecision> PhotographMatcher::decide(std::int64_t now_ns) {
  std::vector<PhotographDecision> decisions;
  while (!held_.empty()) {
    auto decision = decide_first(now_ns);
    if (!decision) break;
    decisions.push_back(std::move(*decision));
  }
  return decisions;
}

std::vector<PhotographDecision> PhotographMatcher::end(std::int64_t now_ns) {
  std::vector<PhotographDecision> decisions = decide(now_ns);
  while (!held_.empty()) decisions.push_back(reject(nobody(held_.front())));
  return decisions;
}

}  // namespace strobe::host
