#include "host/loop/resumption.hpp"

#include <algorithm>

namespace strobe::host {
namespace {

using strobe_msgs::event_t;
using strobe_msgs::shot_t;

// Heartbeats come twice a second. A firmware that comes later is asked then.
constexpr Duration kStatusWait = std::chrono::seconds{3};
// A shot under way and its photograph take less.
constexpr Duration kLongestResumption = std::chrono::minutes{2};
// Of the heartbeats about a shot, as far as its clock is related to the host's by them.
constexpr Duration kClockWindow = std::chrono::minutes{2};

}  // namespace

Resumption::Resumption(HostLoop& loop, FormerRuns former)
    : loop_(loop), former_(std::move(former)), entered_(loop.now()) {
  Session& session = loop_.session();
  session.adopt(former_.host_ids);
  for (const auto& [key, counts] : former_.results) session.mark_known(key);
  for (const auto& [key, shot] : former_.shots)
    if (!former_.own(shot) || shot.plan.dry) session.mark_known(key);
  for (const event_t& event : former_.events) {
    // Told in its day.
    if (event.kind == event_t::REPAIRED) {
      session.ledger().add(event.boot_id, event.sequence, loop_.now());
    } else {
      session.on_event(event, loop_.now());
    }
  }
  former_.events.clear();
  session.hold_photograph_timeouts(true);
  loop_.mark_read_out(former_.read_out);
  loop_.add_listener(*this);
}

/// Not before the loop has its photographs.
void Resumption::begin() {
  begun_ = true;
  for (const ShotKey& key : former_.unfinished()) {
    loop_.process(former_.shots.at(key));
    const auto frame = former_.frames.find(key);
    if (frame != former_.frames.end()) loop_.process(frame->second);
  }
  enter(Phase::fetching);
  recovery_.emplace(loop_.now());
}

void Resumption::enter(Phase phase) {
  phase_ = phase;
  entered_ = loop_.now();
}

bool Resumption::fetched() {
  if (!loop_.session().status()) {
    recovery_.emplace(loop_.now());
    return loop_.now() - entered_ > kStatusWait;
  }
  return recovery_->finished(loop_.session(), loop_.now());
}

bool Resumption::finished() {
  if (!begun_) begin();
  Session& session = loop_.session();
  if (phase_ == Phase::fetching && fetched()) {
    measure_photographs();
    enter(Phase::measuring);
  }
  if (phase_ == Phase::measuring && (!loop_.photographs() || loop_.photographs()->left() == 0)) {
    session.hold_photograph_timeouts(false);
    enter(Phase::finishing);
  }
  const bool over = !session.waits_for_adopted() || loop_.now() - entered_ > kLongestResumption;
  if (phase_ == Phase::finishing && over) {
    if (loop_.live_status()) session.give_up_adopted();
    enter(Phase::finished);
  }
  return phase_ == Phase::finished;
}

void Resumption::on_shot(const shot_t& shot) {
  former_.shots.try_emplace({shot.boot_id, shot.shot_id}, shot);
}

void Resumption::on_shot_result(const Shot& result) {
  former_.results.try_emplace({result.boot_id, result.shot_id}, !result.rejected);
}

LeftShots Resumption::left_shots() const {
  LeftShots left;
  const std::set<ShotKey> unfinished = former_.unfinished();
  for (const auto& [key, shot] : former_.shots) {
    left.exposures.push_back(shot);
    const auto frame = former_.frames.find(key);
    if (frame != former_.frames.end()) {
      left.photographed.insert(key);
      left.names_used.insert(std::filesystem::path(frame->second.photograph).filename().string());
    } else if (unfinished.contains(key)) {
      left.wanted.insert(key);
    }
  }
  return left;
}

/// Of the heartbeats about the shots that matter.
DeviceClock Resumption::clock_of_logs(const std::set<ShotKey>& wanted) const {
  DeviceClock clock;
  for (const HeardHeartbeat& heartbeat : former_.heartbeats) {
    const bool near = std::ranges::any_of(wanted, [&](const ShotKey& key) {
      if (key.boot_id != heartbeat.boot_id) return false;
      const Duration apart = heartbeat.device.mono - from_ns(former_.shots.at(key).start_ns);
      return apart < kClockWindow && apart > -kClockWindow;
    });
    if (near) clock.on_heartbeat(heartbeat.boot_id, heartbeat.device, heartbeat.heard);
  }
  return clock;
}

void Resumption::measure_photographs() {
  const LeftShots left = left_shots();
  if (!loop_.photographs() || left.wanted.empty()) return;
  loop_.photographs()->measure_left(left, clock_of_logs(left.wanted));
}

namespace {

constexpr Duration kTimeout = std::chrono::minutes{1};
constexpr Duration kNoProgressTimeout = std::chrono::seconds{15};
// A status that arrives within this time may have been sent before the start.
constexpr Duration kTransit = milliseconds{100};

}  // namespace

bool GapRecovery::finished(const Session& session, HostTime now) {
  const EventLedger& ledger = session.ledger();
  if (ledger.received() != received_ || progress_ == HostTime{}) progress_ = now;
  received_ = ledger.received();
  if (now - started_ > kTimeout || now - progress_ > kNoProgressTimeout) return true;
  if (!session.status()) return true;  // nobody can be asked
  if (!ledger.complete()) return false;
  return !session.live_status(now) || session.status_heard() > started_ + kTransit;
}

}  // namespace strobe::host
