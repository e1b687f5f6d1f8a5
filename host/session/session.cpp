#include "host/session/session.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <string_view>

#include "common/messages/danger.hpp"

namespace strobe::host {
namespace {

using reduction::Flag;
using strobe_msgs::event_t;
using strobe_msgs::frame_t;
using strobe_msgs::shot_t;
using strobe_msgs::status_t;

// Nobody may miss it.
constexpr Duration kDangerEvery = std::chrono::seconds{10};
constexpr Duration kSummaryGrace = milliseconds{300};
// An ask and its answer each pass a lossy link: at 50 % loss 24 in vain have a chance of 0.1 %.
constexpr int kSummaryRequests = 24;
// A photograph takes its time; who asks for its shot again gets it, too, if it was lost on the way.
constexpr Duration kPhotographGrace = std::chrono::seconds{1};
// A machine that is this much early still meets the plate before the abort.
constexpr double kMachineLagTolerance_s = 0.1;

/// Of what was measured: two hosts that measure one photograph alike give the same frame.
std::uint64_t hash_of(frame_t frame) {
  frame.host_id = 0;
  frame.photograph.clear();
  std::string bytes(static_cast<std::size_t>(frame.getEncodedSize()), '\0');
  frame.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return std::hash<std::string_view>{}(bytes);
}

MonoTime end_of(const shot_t& shot, MonoTime fallback) {
  MonoTime end = from_ns(shot.shutter_close_ns);
  for (const auto& flash : shot.flashes) end = std::max(end, from_ns(flash.issue_end_ns));
  return known(end) && end != MonoTime{} ? end : fallback;
}

}  // namespace

/// The photograph's time runs from the end of the shot, or from now if that is over or cannot be known.
void Session::set_deadline(PendingShot& waiting) const {
  const Duration timeout = from_seconds(settings_.analysis.photograph_timeout_s);
  const MonoTime end = end_of(waiting.shot, kNoTime);
  const auto ended = known(end) ? heard_.at(waiting.shot.boot_id, end) : heard_.now();
  waiting.deadline = ended.value_or(heard_.now()) + timeout;
  if (ended && waiting.deadline >= heard_.now()) return;
  // It was lost until now, and its photograph with it, which may come again as it has.
  waiting.deadline = heard_.now() + timeout;
  waiting.past = !own(waiting.shot) && (ended || ran_earlier(waiting.shot.boot_id));
}

void Session::on_event(const event_t& event, HostTime now) {
  boots_.on_event(event.boot_id, event.sequence, now);
  if (!ledger_.add(event.boot_id, event.sequence, now)) return;
  const ShotKey key{event.boot_id, event.shot_id};
  if (event.kind == event_t::ARMED) {
    const std::int64_t host = messages::host_id_in(event.detail);
    armed_.put({event.boot_id, event.sequence}, host);
    if (const auto name = messages::host_name_in(event.detail); !name.empty())
      host_names_.put(host, std::string(name));
  }
  if (event.kind == event_t::REPAIRED) notify("strobed found when it started: " + event.detail);
  const bool of_open_shot = event.shot_id > 0 && !done_.contains(key) && !pending_.contains(key);
  if (of_open_shot && event.kind == event_t::SHOT_STARTED) {
    open_[key].started = event.sequence;
    open_[key].dry = event.detail == "dry";
  }
  if (of_open_shot && (event.kind == event_t::SHOT_ENDED || event.kind == event_t::SHOT_ABORTED)) {
    open_[key].ended = event.sequence;
    open_[key].since = now;
  }
  finish_complete_shots();
  finish_interrupted_shots();
}

bool Session::whole(const shot_t& shot) const {
  return shot.first_sequence < 1 || ledger_.holds(shot.boot_id, shot.first_sequence, shot.last_sequence);
}

void Session::on_shot(const shot_t& shot, HostTime now) {
  const ShotKey key{shot.boot_id, shot.shot_id};
  open_.erase(key);
  if (done_.contains(key) || pending_.contains(key)) return;
  if (shot.plan.dry) return finish_dry(shot);
  auto frame = take_early_frame(key);
  if (frame && whole(shot)) return finish(shot, *frame);
  if (!frame && shot.aborted && ball_came_after_abort(shot)) {
    return finish_without_photograph(shot, Flag::too_few_images,
                                     "aborted before the ball came: " + shot.abort_reason);
  }
  PendingShot waiting;
  waiting.shot = shot;
  waiting.frame = std::move(frame);
  waiting.local_deadline = now + from_seconds(settings_.analysis.photograph_timeout_s) + kCutOff;
  waiting.asked = now;
  waiting.number = ++arrivals_;
  set_deadline(waiting);
  pending_[key] = std::move(waiting);
}

void Session::on_frame(const frame_t& frame, HostTime /*now*/) {
  const auto found = waiting_for(frame);
  if (found == pending_.end()) return keep_or_report_frame(frame);
  if (!whole(found->second.shot)) {
    if (!found->second.frame) found->second.frame = frame;
    return;
  }
  const shot_t shot = std::move(found->second.shot);
  pending_.erase(found);
  finish(shot, frame);
}

/// A frame that does not know its firmware belongs to the running one's shot of that number, or else to the
/// newest.
std::map<ShotKey, Session::PendingShot>::iterator Session::waiting_for(const frame_t& frame) {
  if (frame.boot_id != 0) return pending_.find({frame.boot_id, frame.shot_id});
  auto newest = pending_.end();
  for (auto it = pending_.begin(); it != pending_.end(); ++it) {
    if (it->first.shot_id != frame.shot_id) continue;
    if (status_ && it->first.boot_id == status_->boot_id) return it;
    if (newest == pending_.end() || it->second.number > newest->second.number) newest = it;
  }
  return newest;
}

void Session::keep_or_report_frame(const frame_t& frame) {
  const auto same = [&frame](const auto& entry) {
    return entry.first.shot_id == frame.shot_id &&
           (frame.boot_id == 0 || entry.first.boot_id == frame.boot_id);
  };
  const auto done = std::find_if(done_.begin(), done_.end(), same);
  if (done == done_.end()) {
    early_frames_.put({frame.boot_id, frame.shot_id}, frame);
    return;
  }
  const std::uint64_t hash = hash_of(frame);
  const std::optional<std::uint64_t> before = std::exchange(done->second.frame_hash, hash);
  if (!before && done->second.photograph_missed) {
    notify(fmt::format("the photograph of shot {} came too late; it is kept in the log, the readout stands",
                       frame.shot_id));
  } else if (before && *before != hash) {
    notify(fmt::format("a second, different frame of shot {} came; it is kept in the log, the readout stands",
                       frame.shot_id));
  }
}

std::optional<frame_t> Session::take_early_frame(const ShotKey& key) {
  auto frame = early_frames_.take(key);
  return frame ? frame : early_frames_.take({0, key.shot_id});
}

bool Session::ball_came_after_abort(const shot_t& shot) const {
  const MonoTime trigger = from_ns(shot.trigger_ns);
  if (!known(trigger)) return true;
  if (!settings_.machine_lag_s) return false;
  const Duration earliest = from_seconds(std::max(0.0, *settings_.machine_lag_s - kMachineLagTolerance_s));
  return end_of(shot, trigger) < trigger + earliest;
}

void Session::mark_finished(const ShotKey& key, FinishedShot how) {
  assert(!done_.contains(key) && !pending_.contains(key));
  done_[key] = how;
}

/// What the shot itself does not tell. The clock is judged by the firmware's own clocks alone, so that a log
/// gives the same flags wherever it is played.
void Session::add_flags(const shot_t& shot, reduction::FlagSet& flags) const {
  if (!whole(shot)) flags.set(Flag::events_missing);
  const MonoTime start = from_ns(shot.start_ns);
  if (clock_.suspended_within(shot.boot_id, start, end_of(shot, start))) flags.set(Flag::clock_suspect);
}

void Session::finish(const shot_t& shot, const frame_t& frame) {
  mark_finished({shot.boot_id, shot.shot_id}, {hash_of(frame), false});
  reduction::FlagSet flags;
  add_flags(shot, flags);
  push(measured_shot(shot, frame, flags, settings_));
}

void Session::finish_without_photograph(const shot_t& shot, Flag why, std::string problem) {
  mark_finished({shot.boot_id, shot.shot_id}, {std::nullopt, why == Flag::no_photograph});
  reduction::FlagSet flags;
  flags.set(why);
  add_flags(shot, flags);
  push(unmeasured_shot(shot, flags, std::move(problem)));
}

void Session::finish_dry(const shot_t& shot) {
  mark_finished({shot.boot_id, shot.shot_id}, {});
  push(dry_shot(shot));
}

/// Who armed for it: the last one before its start.
std::int64_t Session::host_of(const ShotKey& key, const OpenShot& open) const {
  const auto& armed = armed_.all();
  const auto after = armed.lower_bound({key.boot_id, open.started});
  if (open.started < 1 || after == armed.begin() || std::prev(after)->first.first != key.boot_id) return 0;
  return std::prev(after)->second;
}

/// The firmware died before it had written the shot's summary.
void Session::finish_interrupted(const ShotKey& key, const OpenShot& open, const char* why) {
  mark_finished(key, {});
  push(interrupted_shot(key, host_of(key, open), open.dry, why));
}

void Session::finish_interrupted_shots() {
  for (auto it = open_.begin(); it != open_.end();) {
    const auto& [key, open] = *it;
    const bool asked_enough = open.ended == 0 || open.asked >= kSummaryRequests;
    if (open.started == 0 || !asked_enough || !ledger_.ended_and_complete(key.boot_id)) {
      ++it;
      continue;
    }
    if (open.ended != 0) ledger_.cancel_request(key.boot_id, open.ended);
    finish_interrupted(key, open, "strobed ended during the shot; what it had not yet written is lost");
    it = open_.erase(it);
  }
}

void Session::mark_known(const ShotKey& key) {
  if (!pending_.contains(key)) done_.try_emplace(key);
  open_.erase(key);
}

bool Session::waits_for_adopted() const {
  const auto runs = [this](const auto& entry) {
    return status_ && entry.first.boot_id == status_->boot_id && adopted(host_of(entry.first, entry.second));
  };
  return std::ranges::any_of(open_, runs) || std::ranges::any_of(pending_, [this](const auto& entry) {
           return adopted(entry.second.shot.host_id);
         });
}

void Session::give_up_adopted() {
  for (auto it = open_.begin(); it != open_.end();) {
    const auto& [key, open] = *it;
    if (!adopted(host_of(key, open))) {
      ++it;
      continue;
    }
    if (open.ended != 0) ledger_.cancel_request(key.boot_id, open.ended);
    finish_interrupted(key, open, "no journal that can be reached has its summary");
    it = open_.erase(it);
  }
}

/// Shots whose photograph is here, and now their last event.
void Session::finish_complete_shots() {
  for (auto it = pending_.begin(); it != pending_.end();) {
    if (!it->second.frame || !whole(it->second.shot)) {
      ++it;
      continue;
    }
    const PendingShot waiting = std::move(it->second);
    it = pending_.erase(it);
    finish(waiting.shot, *waiting.frame);
  }
}

bool Session::over(const PendingShot& waiting, bool silent, HostTime now) const {
  return heard_.now() > waiting.deadline || (silent && now > waiting.local_deadline);
}

void Session::expire(HostTime now) {
  const bool silent = !live_status(now);
  for (auto it = pending_.begin(); it != pending_.end();) {
    const bool held = holds_ && adopted(it->second.shot.host_id);
    if (held || !over(it->second, silent, now)) {
      ++it;
      continue;
    }
    const PendingShot waiting = std::move(it->second);
    it = pending_.erase(it);
    finish_late(waiting, fmt::format("no photograph within {} s", settings_.analysis.photograph_timeout_s));
  }
}

void Session::finish_late(const PendingShot& waiting, const std::string& problem) {
  if (waiting.frame) return finish(waiting.shot, *waiting.frame);
  if (!waiting.past) return finish_without_photograph(waiting.shot, Flag::no_photograph, problem);
  mark_finished({waiting.shot.boot_id, waiting.shot.shot_id}, {});
  notify(fmt::format("shot {} was over before this session was joined, and its photograph did not come again",
                     waiting.shot.shot_id));
}

void Session::request_lost_summaries(HostTime now) {
  for (auto& [key, open] : open_) {
    if (open.ended == 0 || now - open.since < kSummaryGrace) continue;
    ledger_.request_again(key.boot_id, open.ended);
    open.since = now;
    ++open.asked;
  }
}

void Session::request_lost_photographs(HostTime now) {
  for (auto& [key, waiting] : pending_) {
    if (waiting.frame || !own(waiting.shot) || now - waiting.asked < kPhotographGrace) continue;
    ledger_.request_again(key.boot_id, waiting.shot.last_sequence);
    waiting.asked = now;
  }
}

void Session::on_time(HostTime now) {
  if (!danger_.empty() && now - danger_told_ >= kDangerEvery) {
    danger_told_ = now;
    notify(danger_);
  }
  for (std::string& text : boots_.take_notifications()) notify(std::move(text));
  expire(now);
  request_lost_summaries(now);
  request_lost_photographs(now);
  finish_interrupted_shots();
}

std::size_t Session::waiting_for_photograph() const {
  return static_cast<std::size_t>(
      std::count_if(pending_.begin(), pending_.end(), [](const auto& entry) { return !entry.second.past; }));
}

void Session::on_end() {
  while (!pending_.empty()) {
    const PendingShot waiting = std::move(pending_.begin()->second);
    pending_.erase(pending_.begin());
    finish_late(waiting, "no photograph in the log");
  }
}

void HeardTime::on_heartbeat(std::int64_t boot_id, MonoTime sent) {
  const Boot* before = boots_.find(boot_id);
  const Duration passed = before ? sent - before->newest : Duration{};
  if (passed < Duration{}) return;
  if (passed <= kSilent) now_ += passed;
  assert(now_ >= Duration{});
  boots_.put(boot_id, {sent, now_});
}

std::optional<Duration> HeardTime::at(std::int64_t boot_id, MonoTime instant) const {
  const Boot* boot = boots_.find(boot_id);
  return boot ? std::optional(boot->at + (instant - boot->newest)) : std::nullopt;
}

// What the session makes of the firmware's status messages.

void Session::on_status(const strobe_msgs::status_t& status, HostTime now, const std::string& sender) {
  const bool known = boots_.knows(status.boot_id);
  boots_.on_status(status, sender, now);
  if (outdated(status, now)) return;
  // Of two that are heard in turn none is started anew.
  const bool in_turn = known && now - status_heard_ <= kSilent;
  if (status_ && status_->boot_id != status.boot_id && !in_turn) {
    notify(fmt::format("the firmware was started anew (boot {:x})", status.boot_id));
  }
  const DeviceReading device{from_ns(status.mono_ns), from_ns<WallTime>(status.wall_ns),
                             Duration{status.boot_time_ns}};
  heard_.on_heartbeat(status.boot_id, device.mono);
  clock_.on_heartbeat(status.boot_id, device, now);
  report_clock();
  report_danger(status, now);
  report_arming(status);
  status_ = status;
  status_heard_ = now;
  if (host_id_ != 0 && status.arm_host_id == host_id_) answered_boot_ = status.boot_id;
  ledger_.status(status.boot_id, status.last_sequence, now);
  std::vector<EndedBoot> earlier;
  for (const auto& boot : status.earlier) earlier.push_back({boot.boot_id, boot.last_sequence});
  ledger_.earlier(earlier, now);
  finish_interrupted_shots();
  expire(now);
}

void Session::report_danger(const status_t& status, HostTime now) {
  if (!messages::tells_danger(status.message)) {
    if (!danger_.empty()) notify("the outputs are inactive again; the firmware was heard to say so");
    return danger_.clear();
  }
  if (danger_ == status.message) return;
  danger_ = status.message;
  danger_told_ = now;
  notify(danger_);
}

void Session::report_arming(const status_t& status) {
  const std::int64_t host = status.arm_host_id;
  if (host == 0 || host == arming_told_ || host == host_id_) return;
  const std::string name = host_name(host);
  if (name.empty()) return;
  arming_told_ = host;
  notify("the rig was armed by " + name);
}

std::string Session::host_name(std::int64_t host_id) const {
  const auto* name = host_names_.find(host_id);
  return name ? *name : "";
}

void Session::on_local_clocks(const HostReading& reading) {
  clock_.on_local(reading);
  report_clock();
}

void Session::report_clock() {
  for (std::string& text : clock_.take_notifications()) notify(std::move(text));
}

std::optional<strobe_msgs::status_t> Session::live_status(HostTime now) const {
  return status_ && now - status_heard_ <= kSilent ? status_ : std::nullopt;
}

bool Session::ran_earlier(std::int64_t boot_id) const {
  return status_ && std::ranges::any_of(status_->earlier,
                                        [boot_id](const auto& boot) { return boot.boot_id == boot_id; });
}

/// Overtaken on the way, or of a log that is played back, whose seals are good. Of two boots the later one
/// lists the other; where their session folders differ, another is believed only when the one heard has
/// fallen silent. A firing host believes any until one has answered it, which no log can, and that one then
/// for a cut's time, as a boot's end is its shots' end.
bool Session::outdated(const strobe_msgs::status_t& status, HostTime now) const {
  if (!status_) return false;
  if (status.boot_id == status_->boot_id) return status.mono_ns < status_->mono_ns;
  if (ran_earlier(status.boot_id)) return true;
  const bool follows = std::ranges::any_of(
      status.earlier, [this](const auto& boot) { return boot.boot_id == status_->boot_id; });
  if (follows) return false;
  if (host_id_ == 0) return now - status_heard_ <= kSilent;
  return status_->boot_id == answered_boot_ && now - status_heard_ <= kCutOff;
}

}  // namespace strobe::host
