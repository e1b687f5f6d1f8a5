#include "host/clock/clock_relation.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::host {
namespace {

// A message that comes earlier than this was not sent by the clock that is known here.
constexpr double kTooEarly_s = 0.005;
// Heartbeats that are all late by as much as this, and by the same, are not late: the clock was stopped.
constexpr double kTooLate_s = 0.25;
constexpr double kAlike_s = 0.05;
constexpr std::size_t kLateInARow = 8;
constexpr std::size_t kMaxPoints = 400;  // of a line
constexpr std::size_t kMaxHeard = 1300;
constexpr std::size_t kMaxKept = 64;
constexpr Duration kFitEvery = std::chrono::seconds{5};
// From so many heartbeats on, one more changes little.
constexpr std::size_t kSettled = 40;
// Kernels discipline a clock by 500 ppm at most; two may be disciplined.
constexpr double kPlausibleDrift = 1.1e-3;

}  // namespace

double ClockRelation::offset_s(const Segment& segment, MonoTime sent) const {
  return segment.line ? segment.line->offset_s(to_seconds(sent - segment.first_sent)) : segment.min_offset_s;
}

double ClockRelation::lateness_s(const Heartbeat& heartbeat) const {
  const Segment& segment = segments_.back();
  return to_seconds(heartbeat.offset() - segment.origin) - offset_s(segment, heartbeat.sent);
}

/// A clock that was started anew begins below, any other machine's gives another offset.
bool ClockRelation::may_hold_for(const DeviceReading& device, HostTime heard) const {
  if (heartbeats_.empty() || device.mono <= heartbeats_.back().sent) return false;
  const Heartbeat heartbeat{device.mono, heard};
  const auto change = ClockStepDetector(device_watch_).on_reading(device);
  const double late_s = lateness_s(heartbeat) - (change ? to_seconds(change->suspended) : 0.0);
  return late_s < kTooLate_s && (late_s >= -kTooEarly_s || !earlier_than_any(heartbeat));
}

void ClockRelation::on_heartbeat(const DeviceReading& device, HostTime heard) {
  const Heartbeat heartbeat{device.mono, heard};
  const MonoTime before = heartbeats_.empty() ? heartbeat.sent : heartbeats_.back().sent;
  if (!heartbeats_.empty() && heartbeat.sent <= before) return;  // overtaken on the way, or doubled
  const auto change = device_watch_.on_reading(device);
  if (change) {
    for (std::string& text : in_words(*change, "the firmware's machine"))
      notifications_.push_back(std::move(text));
  }
  const bool slept = change && change->suspended != Duration{};
  if (slept) sleeps_.emplace_back(before, heartbeat.sent);
  if (sleeps_.size() > kMaxKept) sleeps_.erase(sleeps_.begin());
  if (heartbeats_.empty() || slept) return begin(heartbeat);
  if (broken_by(heartbeat)) {
    notifications_.push_back(
        "the firmware's clock and this machine's do not go together any more; their relation "
        "begins anew");
    const std::vector<Heartbeat> kept = std::exchange(late_, {});
    begin(kept.empty() ? heartbeat : kept.front());
    for (std::size_t i = 1; i < kept.size(); ++i) add(kept[i]);
    return;
  }
  add(heartbeat);
}

/// Than the latest heartbeats and any plausible drift allow: of forty some were not late. The line alone
/// does not show it: a young one may be of late heartbeats.
bool ClockRelation::earlier_than_any(const Heartbeat& heartbeat) const {
  const std::size_t recent = std::min(heartbeats_.size(), kMinSamplesForLine);
  const double allowed_s = recent < kMinSamplesForLine ? kTooLate_s : kTooEarly_s;
  return std::all_of(heartbeats_.end() - static_cast<std::ptrdiff_t>(recent), heartbeats_.end(),
                     [&](const Heartbeat& before) {
                       const double passed_s = to_seconds(heartbeat.sent - before.sent);
                       const double gained_s = to_seconds(heartbeat.heard - before.heard) - passed_s;
                       return gained_s < -allowed_s - kPlausibleDrift * passed_s;
                     });
}

bool ClockRelation::broken_by(const Heartbeat& heartbeat) {
  const double late_s = lateness_s(heartbeat);
  if (late_s < -kTooEarly_s && earlier_than_any(heartbeat)) {
    late_.clear();
    return true;
  }
  const bool alike = late_.empty() || std::abs(late_s - lateness_s(late_.front())) < kAlike_s;
  if (late_s < kTooLate_s || !alike) late_.clear();
  if (late_s >= kTooLate_s) late_.push_back(heartbeat);
  return late_.size() >= kLateInARow;
}

void ClockRelation::begin(const Heartbeat& heartbeat) {
  heartbeats_.clear();
  late_.clear();
  estimate_.reset();
  estimated_ = {};
  Segment segment;
  segment.first_sent = heartbeat.sent;
  segment.origin = heartbeat.offset();
  segments_.push_back(segment);
  if (segments_.size() > kMaxKept) segments_.erase(segments_.begin());
  add(heartbeat);
}

void ClockRelation::add(const Heartbeat& heartbeat) {
  heartbeats_.push_back(heartbeat);
  while (heartbeats_.size() > kMaxHeard || heartbeat.sent - heartbeats_.front().sent > kMemory)
    heartbeats_.pop_front();
  Segment& segment = segments_.back();
  ++segment.heartbeats;
  segment.min_offset_s = std::min(segment.min_offset_s, to_seconds(heartbeat.offset() - segment.origin));
  if (segment.line && heartbeat.sent - fitted_ < kFitEvery) return;
  if (heartbeats_.size() < kMinSamplesForLine) return;
  fitted_ = heartbeat.sent;
  std::vector<ClockSample> recent = points(kWindow);
  if (recent.size() > kMaxPoints) recent.erase(recent.begin(), recent.end() - kMaxPoints);
  if (auto line = fit_clock(recent)) segment.line = *line;
}

std::vector<ClockSample> ClockRelation::points(Duration last) const {
  const Segment& segment = segments_.back();
  std::vector<ClockSample> points;
  for (const Heartbeat& heartbeat : heartbeats_) {
    if (heartbeats_.back().sent - heartbeat.sent > last) continue;
    points.push_back(
        {to_seconds(heartbeat.sent - segment.first_sent), to_seconds(heartbeat.offset() - segment.origin)});
  }
  return points;
}

const ClockRelation::Segment& ClockRelation::of(MonoTime device) const {
  for (std::size_t i = segments_.size(); i-- > 1;) {
    if (device >= segments_[i].first_sent) return segments_[i];
  }
  return segments_.front();
}

HostTime ClockRelation::local(MonoTime device) const {
  const Segment& segment = of(device);
  return HostTime{device.time_since_epoch() + segment.origin + from_seconds(offset_s(segment, device))};
}

void ClockRelation::renew_estimate() {
  const MonoTime newest = heartbeats_.back().sent;
  const bool settled = estimate_ && heartbeats_.size() >= kSettled;
  if (newest == estimated_ || (settled && newest - estimated_ < kFitEvery)) return;
  estimated_ = newest;
  estimate_ = estimate_clock(points(kMemory));
}

ClockState ClockRelation::state() {
  ClockState state;
  const Segment& segment = segments_.back();
  state.heartbeats = segment.heartbeats;
  state.latency_s = lateness_s(heartbeats_.back());
  for (const Heartbeat& heartbeat : heartbeats_) {
    if (heartbeats_.back().sent - heartbeat.sent <= kWindow)
      state.worst_latency_s = std::max(state.worst_latency_s, lateness_s(heartbeat));
  }
  renew_estimate();
  if (!estimate_) return state;
  const ClockEstimate now = estimate_->at(to_seconds(heartbeats_.back().sent - segment.first_sent));
  state.drift_ppm = now.drift * 1e6;
  state.drift_sd_ppm = std::sqrt(now.drift_var) * 1e6;
  state.offset_s = to_seconds(segment.origin) + now.offset_s;
  state.offset_sd_s = std::sqrt(now.offset_var_s2);
  state.suspect = heartbeats_.size() >= kMinSamplesForLine &&
                  std::abs(*state.drift_ppm) - 3.0 * state.drift_sd_ppm > kPlausibleDrift * 1e6;
  return state;
}

bool ClockRelation::suspended_within(MonoTime from, MonoTime to) const {
  return std::any_of(sleeps_.begin(), sleeps_.end(),
                     [&](const auto& sleep) { return sleep.first < to && sleep.second > from; });
}

}  // namespace strobe::host
