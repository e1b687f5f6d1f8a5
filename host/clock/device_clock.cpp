#include "host/clock/device_clock.hpp"

#include <fmt/format.h>

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
constexpr std::int64_t kFitEvery_ns = 5'000'000'000;
// From so many heartbeats on, one more changes little.
constexpr std::size_t kSettled = 40;
// Kernels discipline a clock by 500 ppm at most; two may be disciplined.
constexpr double kPlausibleDrift = 1.1e-3;
constexpr double kNs = 1e-9;

double as_seconds(std::int64_t ns) { return static_cast<double>(ns) * kNs; }

}  // namespace

double DeviceClock::offset_s(const Segment& segment, std::int64_t sent_ns) const {
  return segment.line ? segment.line->offset_s(as_seconds(sent_ns - segment.first_sent_ns))
                      : segment.min_offset_s;
}

double DeviceClock::lateness_s(const Heartbeat& heartbeat) const {
  const Segment& segment = segments_.back();
  return as_seconds(heartbeat.heard_ns - heartbeat.sent_ns - segment.origin_ns) -
         offset_s(segment, heartbeat.sent_ns);
}

void DeviceClock::notify_changes(const ClockStepDetector::Change& change, const std::string& whose) {
  if (change.stepped_ns != 0) {
    notifications_.push_back(
        fmt::format("the wall clock of {} was set by {:+.1f} s; times measured are not touched", whose,
                    as_seconds(change.stepped_ns)));
  }
  if (change.suspended_ns != 0) {
    notifications_.push_back(
        fmt::format("{} was suspended for {:.1f} s", whose, as_seconds(change.suspended_ns)));
  }
}

void DeviceClock::on_local(const ClockReading& local) {
  if (const auto change = local_watch_.on_reading(local)) notify_changes(*change, "this machine");
}

void DeviceClock::on_heartbeat(std::int64_t boot_id, const ClockReading& device, std::int64_t heard_ns) {
  const Heartbeat heartbeat{device.mono_ns, heard_ns};
  const bool anew = boot_id != boot_id_;
  boot_id_ = boot_id;
  const bool older = !heartbeats_.empty() && heartbeat.sent_ns <= heartbeats_.back().sent_ns;
  if (older && !anew) return;  // overtaken on the way, or doubled
  const std::int64_t before_ns = heartbeats_.empty() ? heartbeat.sent_ns : heartbeats_.back().sent_ns;
  if (older) device_watch_.forget();
  const auto change = device_watch_.on_reading(device);
  if (change) notify_changes(*change, "the firmware's machine");
  const bool slept = change && change->suspended_ns != 0;
  if (slept) sleeps_.emplace_back(before_ns, heartbeat.sent_ns);
  if (sleeps_.size() > kMaxKept) sleeps_.erase(sleeps_.begin());
  if (heartbeats_.empty() || older || slept) return begin(heartbeat);
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
/// cannot tell: a young one may be of late heartbeats.
bool DeviceClock::earlier_than_any(const Heartbeat& heartbeat) const {
  const std::size_t recent = std::min(heartbeats_.size(), kMinSamplesForLine);
  const double allowed_s = recent < kMinSamplesForLine ? kTooLate_s : kTooEarly_s;
  return std::all_of(heartbeats_.end() - static_cast<std::ptrdiff_t>(recent), heartbeats_.end(),
                     [&](const Heartbeat& before) {
                       const double passed_s = as_seconds(heartbeat.sent_ns - before.sent_ns);
                       const double gained_s = as_seconds(heartbeat.heard_ns - before.heard_ns) - passed_s;
                       return gained_s < -allowed_s - kPlausibleDrift * passed_s;
                     });
}

bool DeviceClock::broken_by(const Heartbeat& heartbeat) {
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

void DeviceClock::begin(const Heartbeat& heartbeat) {
  heartbeats_.clear();
  late_.clear();
  estimate_.reset();
  estimated_ns_ = 0;
  Segment segment;
  segment.first_sent_ns = heartbeat.sent_ns;
  segment.origin_ns = heartbeat.heard_ns - heartbeat.sent_ns;
  segments_.push_back(segment);
  if (segments_.size() > kMaxKept) segments_.erase(segments_.begin());
  add(heartbeat);
}

void DeviceClock::add(const Heartbeat& heartbeat) {
  heartbeats_.push_back(heartbeat);
  while (heartbeats_.size() > kMaxHeard || heartbeat.sent_ns - heartbeats_.front().sent_ns > kMemory_ns)
    heartbeats_.pop_front();
  Segment& segment = segments_.back();
  ++segment.heartbeats;
  const double offset_s = as_seconds(heartbeat.heard_ns - heartbeat.sent_ns - segment.origin_ns);
  segment.min_offset_s = std::min(segment.min_offset_s, offset_s);
  if (segment.line && heartbeat.sent_ns - fitted_ns_ < kFitEvery_ns) return;
  if (heartbeats_.size() < kMinSamplesForLine) return;
  fitted_ns_ = heartbeat.sent_ns;
  std::vector<ClockSample> recent = points(kWindow_ns);
  if (recent.size() > kMaxPoints) recent.erase(recent.begin(), recent.end() - kMaxPoints);
  if (auto line = fit_clock(recent)) segment.line = *line;
}

std::vector<ClockSample> DeviceClock::points(std::int64_t last_ns) const {
  const Segment& segment = segments_.back();
  std::vector<ClockSample> points;
  for (const Heartbeat& heartbeat : heartbeats_) {
    if (heartbeats_.back().sent_ns - heartbeat.sent_ns > last_ns) continue;
    points.push_back({as_seconds(heartbeat.sent_ns - segment.first_sent_ns),
                      as_seconds(heartbeat.heard_ns - heartbeat.sent_ns - segment.origin_ns)});
  }
  return points;
}

const DeviceClock::Segment& DeviceClock::of(std::int64_t device_ns) const {
  for (std::size_t i = segments_.size(); i-- > 1;) {
    const bool follows = segments_[i].first_sent_ns > segments_[i - 1].first_sent_ns;
    if (device_ns >= segments_[i].first_sent_ns || !follows) return segments_[i];
  }
  return segments_.front();
}

std::optional<std::int64_t> DeviceClock::local_ns(std::int64_t device_ns) const {
  if (segments_.empty()) return std::nullopt;
  const Segment& segment = of(device_ns);
  return device_ns + segment.origin_ns +
         static_cast<std::int64_t>(std::llround(offset_s(segment, device_ns) / kNs));
}

void DeviceClock::renew_estimate() {
  const std::int64_t newest_ns = heartbeats_.back().sent_ns;
  const bool settled = estimate_ && heartbeats_.size() >= kSettled;
  if (newest_ns == estimated_ns_ || (settled && newest_ns - estimated_ns_ < kFitEvery_ns)) return;
  estimated_ns_ = newest_ns;
  estimate_ = estimate_clock(points(kMemory_ns));
}

ClockState DeviceClock::state() {
  ClockState state;
  if (segments_.empty()) return state;
  const Segment& segment = segments_.back();
  state.heartbeats = segment.heartbeats;
  state.latency_s = lateness_s(heartbeats_.back());
  for (const Heartbeat& heartbeat : heartbeats_) {
    if (heartbeats_.back().sent_ns - heartbeat.sent_ns <= kWindow_ns)
      state.worst_latency_s = std::max(state.worst_latency_s, lateness_s(heartbeat));
  }
  renew_estimate();
  if (!estimate_) return state;
  const ClockEstimate now = estimate_->at(as_seconds(heartbeats_.back().sent_ns - segment.first_sent_ns));
  state.drift_ppm = now.drift * 1e6;
  state.drift_sd_ppm = std::sqrt(now.drift_var) * 1e6;
  state.offset_s = as_seconds(segment.origin_ns) + now.offset_s;
  state.offset_sd_s = std::sqrt(now.offset_var_s2);
  state.suspect = heartbeats_.size() >= kMinSamplesForLine &&
                  std::abs(*state.drift_ppm) - 3.0 * state.drift_sd_ppm > kPlausibleDrift * 1e6;
  return state;
}

bool DeviceClock::suspended_within(std::int64_t from_device_ns, std::int64_t to_device_ns) const {
  return std::any_of(sleeps_.begin(), sleeps_.end(), [&](const auto& sleep) {
    return sleep.first < to_device_ns && sleep.second > from_device_ns;
  });
}

}  // namespace strobe::host
