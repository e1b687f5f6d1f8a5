#include "host/photographs/photograph_matcher.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace strobe::host {
namespace {

using strobe_msgs::shot_t;

// The firmware's clock is known here but for the time that a message takes, and to far less than that later
// on.
constexpr Duration kClockTolerance = milliseconds{100};
constexpr int kSds = 4;
// Some file systems keep times to two seconds.
constexpr Duration kFileTimeTolerance = std::chrono::seconds{2};
// Longest that a photograph waits for word of its shot, which may have to be asked for again.
constexpr Duration kClaim = std::chrono::seconds{5};
// What a photograph may take, as multiple of the longest so far, and more.
constexpr int kTimesUsual = 2;
constexpr Duration kAboveUsual = milliseconds{200};
// Longest after a shot that a photograph may still be its.
constexpr Duration kForgotten = std::chrono::minutes{1};
constexpr std::size_t kMaxExposures = 200;

}  // namespace

void PhotographMatcher::on_shot(const shot_t& shot) {
  const ShotKey key{shot.boot_id, shot.shot_id};
  const bool known = std::any_of(exposures_.begin(), exposures_.end(),
                                 [&](const Exposure& exposure) { return exposure.key == key; });
  if (known || shot.shutter_open_ns == shot_t::NO_TIME || shot.shutter_open_ns == 0) return;
  const MonoTime opened = from_ns(shot.shutter_open_ns);
  const MonoTime closed = std::max(from_ns(shot.shutter_close_ns), opened);
  const Exposure exposure{key, opened, closed, !shot.plan.dry, false};
  const auto later = std::find_if(exposures_.begin(), exposures_.end(),
                                  [&](const Exposure& other) { return closed_later(other, exposure); });
  exposures_.insert(later, exposure);
  if (exposures_.size() > kMaxExposures) exposures_.erase(exposures_.begin());
}

/// Boots may have different clocks: instants of two are compared on this machine's.
bool PhotographMatcher::closed_later(const Exposure& one, const Exposure& other) const {
  if (one.key.boot_id == other.key.boot_id) return one.closed > other.closed;
  const auto one_local = clock_.local(one.key.boot_id, one.closed);
  const auto other_local = clock_.local(other.key.boot_id, other.closed);
  return one_local && other_local && *one_local > *other_local;
}

std::optional<PhotographMatcher::Local> PhotographMatcher::local(const Exposure& exposure) const {
  const auto opened = clock_.local(exposure.key.boot_id, exposure.opened);
  const auto closed = clock_.local(exposure.key.boot_id, exposure.closed);
  return opened && closed ? std::optional(Local{*opened, *closed}) : std::nullopt;
}

void PhotographMatcher::on_measured(const ShotKey& shot) {
  for (Exposure& exposure : exposures_) {
    if (exposure.key == shot) exposure.wanted = false;
  }
}

void PhotographMatcher::on_taken(const ShotKey& shot) {
  for (Exposure& exposure : exposures_) {
    if (exposure.key == shot) exposure.taken = true;
  }
}

void PhotographMatcher::give_back(const ShotKey& shot) {
  for (Exposure& exposure : exposures_) {
    if (exposure.key == shot) exposure.taken = false;
  }
}

void PhotographMatcher::on_photograph(int photograph, HostTime arrived, HostTime written,
                                      std::optional<tether::ExposureStart> exposed) {
  held_.push_back({photograph, arrived, written, exposed});
}

/// Shots before one that has its photograph get none any more.
PhotographMatcher::Candidates PhotographMatcher::candidates(const Held& held, HostTime now) const {
  Candidates result;
  for (std::size_t i = exposures_.size(); i-- > 0 && !exposures_[i].taken;) {
    const Exposure& exposure = exposures_[i];
    const auto when = local(exposure);
    if (!when) continue;  // until its boot's clock is known
    if (held.arrived < when->closed - kClockTolerance || held.arrived > when->closed + kForgotten) continue;
    if (held.written < when->opened - kFileTimeTolerance) continue;
    auto& list = now <= when->closed + timeout_ ? result.waiting : result.given_up;
    list.insert(list.begin(), i);
  }
  return result;
}

/// When the photograph of an exposure should have come, as far as earlier ones tell.
HostTime PhotographMatcher::own_due(const Exposure& exposure) const {
  const Duration usual = usual_ ? kTimesUsual * *usual_ + kAboveUsual : timeout_ / 2;
  return local(exposure)->closed + std::min(usual, timeout_ / 5 * 4);
}

/// Whether a photograph would be no slower for this exposure than others have been.
bool PhotographMatcher::may_still_come(const Exposure& exposure, HostTime arrived) const {
  return usual_ && arrived - local(exposure)->closed <= kTimesUsual * *usual_ + kAboveUsual;
}

PhotographDecision PhotographMatcher::take(std::size_t h, std::size_t i, HostTime now, bool certain) {
  Exposure& exposure = exposures_[i];
  const Held held = held_[h];
  held_.erase(held_.begin() + static_cast<std::ptrdiff_t>(h));
  exposure.taken = true;
  const HostTime closed = local(exposure)->closed;
  if (certain) usual_ = std::max(usual_.value_or(Duration{}), held.arrived - closed);
  PhotographDecision decision;
  decision.photograph = held.photograph;
  decision.shot = exposure.key;
  decision.wanted = exposure.wanted;
  decision.late = now > closed + timeout_;
  return decision;
}

PhotographDecision PhotographMatcher::reject(std::size_t h, std::string why) {
  PhotographDecision decision;
  decision.photograph = held_[h].photograph;
  decision.why = std::move(why);
  held_.erase(held_.begin() + static_cast<std::ptrdiff_t>(h));
  return decision;
}

std::string PhotographMatcher::nobody(const Held& held) const {
  if (held.exposed) return "no shot's shutter was open when it was exposed: not used";
  for (const Exposure& exposure : exposures_) {
    const auto when = local(exposure);
    if (!when) continue;
    const bool in_time =
        held.arrived >= when->closed - kClockTolerance && held.arrived <= when->closed + timeout_;
    const Duration before = when->opened - held.written;
    if (in_time && !exposure.taken && before > kFileTimeTolerance) {
      return fmt::format("its file is {:.1f} s older than shot {}: not used", to_seconds(before),
                         exposure.key.shot_id);
    }
  }
  return "no shot waits for a photograph: not used";
}

/// Several shots may be meant.
std::optional<PhotographDecision> PhotographMatcher::choose(const Candidates& candidates, HostTime now) {
  const auto& [waiting, given_up] = candidates;
  const std::size_t oldest = given_up.empty() ? waiting.front() : given_up.front();
  if (held_.size() >= candidates.count()) return take(0, oldest, now, false);
  if (waiting.empty()) {
    return reject(
        0, fmt::format("it came too late, of shot {} or {}: not used",
                       exposures_[given_up.front()].key.shot_id, exposures_[given_up.back()].key.shot_id));
  }
  if (waiting.size() > 1) return std::nullopt;
  if (held_.size() > 1) {
    return reject(0, fmt::format("it came too late, of one of the shots before {}: not used",
                                 exposures_[waiting.front()].key.shot_id));
  }
  // With a camera so slow nothing tells whose it is: wait for another one, or until both are given up.
  if (std::ranges::any_of(
          given_up, [&](std::size_t i) { return may_still_come(exposures_[i], held_.front().arrived); }))
    return std::nullopt;
  // If the one before the newest had come late, the newest shot's own would follow by then.
  if (now < own_due(exposures_[waiting.front()])) return std::nullopt;
  return take(0, waiting.front(), now, false);
}

/// The exposures that it may be of, the most likely first.
std::vector<std::size_t> PhotographMatcher::exposed_within(const tether::ExposureStart& exposed) const {
  const Duration tolerance = kClockTolerance + kSds * exposed.sd;
  std::vector<std::pair<Duration, std::size_t>> found;
  for (std::size_t i = 0; i < exposures_.size(); ++i) {
    const auto when = local(exposures_[i]);
    if (!when || exposed.instant < when->opened - tolerance || exposed.instant > when->closed + tolerance)
      continue;
    found.emplace_back(std::chrono::abs(exposed.instant - when->opened), i);
  }
  std::ranges::sort(found);
  std::vector<std::size_t> indices;
  for (const auto& [distance, i] : found) {
    if (distance <= found.front().first + 2 * tolerance) indices.push_back(i);
  }
  return indices;
}

std::optional<PhotographDecision> PhotographMatcher::decide_exposed(std::size_t h, HostTime now) {
  const std::vector<std::size_t> found = exposed_within(*held_[h].exposed);
  if (found.empty()) {
    if (now - held_[h].arrived < kClaim) return std::nullopt;
    return reject(h, nobody(held_[h]));
  }
  const Exposure& first = exposures_[found.front()];
  if (found.size() > 1)
    return reject(h, fmt::format("it may be of shot {} or {}: not used", first.key.shot_id,
                                 exposures_[found[1]].key.shot_id));
  if (first.taken) return reject(h, fmt::format("a second one of shot {}: not used", first.key.shot_id));
  return take(h, found.front(), now, true);
}

std::optional<PhotographDecision> PhotographMatcher::decide_first(HostTime now) {
  const Candidates found = candidates(held_.front(), now);
  if (found.count() > 1) return choose(found, now);
  if (found.count() == 1)
    return take(0, found.waiting.empty() ? found.given_up[0] : found.waiting[0], now, true);
  if (now - held_.front().arrived < kClaim) return std::nullopt;
  return reject(0, nobody(held_.front()));
}

std::vector<PhotographDecision> PhotographMatcher::decide(HostTime now) {
  std::vector<PhotographDecision> decisions;
  for (std::size_t h = 0; h < held_.size();) {
    auto decision = held_[h].exposed ? decide_exposed(h, now) : std::nullopt;
    if (decision) {
      decisions.push_back(std::move(*decision));
    } else {
      ++h;
    }
  }
  while (!held_.empty() && !held_.front().exposed) {
    auto decision = decide_first(now);
    if (!decision) break;
    decisions.push_back(std::move(*decision));
  }
  return decisions;
}

std::vector<PhotographDecision> PhotographMatcher::end(HostTime now) {
  std::vector<PhotographDecision> decisions = decide(now);
  while (!held_.empty()) decisions.push_back(reject(0, nobody(held_.front())));
  return decisions;
}

}  // namespace strobe::host
