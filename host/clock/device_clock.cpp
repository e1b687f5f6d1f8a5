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
constexpr std::size_t kMostPoints = 400;  // of a line
constexpr std::size_t kMostHeard = 1300;
constexpr std::size_t kMostKept = 64;
constexpr std::int64_t kFitEvery_ns = 5'000'000'000;
// From so many heartbeats on, one more changes little.
constexpr std::size_t kSettled = 40;
// Kernels discipline a clock by 500 ppm at most; two may be disciplined.
constexpr double kPlausibleDrift = 1.1e-3;
constexpr double kNs = 1e-9;

double as_seconds(std::int64_t ns) { return static_cast<double>(ns) * kNs; }

}  // namespace

double DeviceClock::ahead_s(const Stretch& stretch, std::int64_t sent_ns) const {
  return stretch.line ? stretch.line->ahead_s(as_seconds(sent_ns - stretch.first_sent_ns))
                      : stretch.least_ahead_s;
}

double DeviceClock::lateness_s(const Heartbeat& heartbeat) const {
  const Stretch& stretch = stretches_.back();
  return as_seconds(heartbeat.heard_ns - heartbeat.sent_ns - stretch.origin_ns) -
         ahead_s(stretch, heartbeat.sent_ns);
}

void DeviceClock::notice_changes(const ClockWatch::Change& change, const std::string& whose) {
  if (change.stepped_ns != 0) {
    notices_.push_back(
        fmt::format("the wall clock of {} was set by {:+.1f} s; times measured are not touched", whose,
                    as_seconds(change.stepped_ns)));
  }
  if (change.slept_ns != 0) {
    notices_.push_back(fmt::format("{} was suspended for {:.1f} s", whose, as_seconds(change.slept_ns)));
  }
}

void DeviceClock::on_local(const MachineClocks& local) {
  if (const auto change = local_watch_.on_reading(local)) notice_changes(*change, "this machine");
}

void DeviceClock::on_heartbeat(std::int64_t boot_id, const MachineClocks& device, std::int64_t heard_ns) {
  const Heartbeat heartbeat{device.mono_ns, heard_ns};
  const bool anew = boot_id != boot_id_;
  boot_id_ = boot_id;
  const bool older = !heard_.empty() && heartbeat.sent_ns <= heard_.back().sent_ns;
  if (older && !anew) return;  // overtaken on the way, or doubled
  const std::int64_t before_ns = heard_.empty() ? heartbeat.sent_ns : heard_.back().sent_ns;
  if (older) device_watch_.forget();
  const auto change = device_watch_.on_reading(device);
  if (change) notice_changes(*change, "the firmware's machine");
  const bool slept = change && change->slept_ns != 0;
  if (slept) sleeps_.emplace_back(before_ns, heartbeat.sent_ns);
  if (sleeps_.size() > kMostKept) sleeps_.erase(sleeps_.begin());
  if (heard_.empty() || older || slept) return begin(heartbeat);
  if (broken_by(heartbeat)) {
    notices_.push_back(
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
  const std::size_t recent = std::min(heard_.size(), kFewestClockPoints);
  const double allowed_s = recent < kFewestClockPoints ? kTooLate_s : kTooEarly_s;
  return std::all_of(heard_.end() - static_cast<std::ptrdiff_t>(recent), heard_.end(),
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
  heard_.clear();
  late_.clear();
  estimate_.reset();
  estimated_ns_ = 0;
  Stretch stretch;
  stretch.first_sent_ns = heartbeat.sent_ns;
  stretch.origin_ns = heartbeat.heard_ns - heartbeat.sent_ns;
  stretches_.push_back(stretch);
  if (stretches_.size() > kMostKept) stretches_.erase(stretches_.begin());
  add(heartbeat);
}

void DeviceClock::add(const Heartbeat& heartbeat) {
  heard_.push_back(heartbeat);
  while (heard_.size() > kMostHeard || heartbeat.sent_ns - heard_.front().sent_ns > kMemory_ns)
    heard_.pop_front();
  Stretch& stretch = stretches_.back();
  ++stretch.heartbeats;
  const double ahead_s = as_seconds(heartbeat.heard_ns - heartbeat.sent_ns - stretch.origin_ns);
  stretch.least_ahead_s = std::min(stretch.least_ahead_s, ahead_s);
  if (stretch.line && heartbeat.sent_ns - fitted_ns_ < kFitEvery_ns) return;
  if (heard_.size() < kFewestClockPoints) return;
  fitted_ns_ = heartbeat.sent_ns;
  std::vector<ClockPoint> recent = points(kWindow_ns);
  if (recent.size() > kMostPoints) recent.erase(recent.begin(), recent.end() - kMostPoints);
  if (auto line = fit_clock(recent)) stretch.line = *line;
}

std::vector<ClockPoint> DeviceClock::points(std::int64_t last_ns) const {
  const Stretch& stretch = stretches_.back();
  std::vector<ClockPoint> points;
  for (const Heartbeat& heartbeat : heard_) {
    if (heard_.back().sent_ns - heartbeat.sent_ns > last_ns) continue;
    points.push_back({as_seconds(heartbeat.sent_ns - stretch.first_sent_ns),
                      as_seconds(heartbeat.heard_ns - heartbeat.sent_ns - stretch.origin_ns)});
  }
  return points;
}

const DeviceClock::Stretch& DeviceClock::of(std::int64_t device_ns) const {
  for (std::size_t i = stretches_.size(); i-- > 1;) {
    const bool follows = stretches_[i].first_sent_ns > stretches_[i - 1].first_sent_ns;
    if (device_ns >= stretches_[i].first_sent_ns || !follows) return stretches_[i];
  }
  return stretches_.front();
}

std::optional<std::int64_t> DeviceClock::local_ns(std::int64_t device_ns) const {
  if (stretches_.empty()) return std::nullopt;
  const Stretch& stretch = of(device_ns);
  return device_ns + stretch.origin_ns +
         static_cast<std::int64_t>(std::llround(ahead_s(stretch, device_ns) / kNs));
}

void DeviceClock::renew_estimate() {
  const std::int64_t newest_ns = heard_.back().sent_ns;
  const bool settled = estimate_ && heard_.size() >= kSettled;
  if (newest_ns == estimated_ns_ || (settled && newest_ns - estimated_ns_ < kFitEvery_ns)) return;
  estimated_ns_ = newest_ns;
  estimate_ = estimate_clock(points(kMemory_ns));
}

ClockState DeviceClock::state() {
  ClockState state;
  if (stretches_.empty()) return state;
  const Stretch& stretch = stretches_.back();
  state.heartbeats = stretch.heartbeats;
  state.latency_s = lateness_s(heard_.back());
  for (const Heartbeat& heartbeat : heard_) {
    if (heard_.back().sent_ns - heartbeat.sent_ns <= kWindow_ns)
      state.worst_latency_s = std::max(state.worst_latency_s, lateness_s(heartbeat));
  }
  renew_estimate();
  if (!estimate_) return state;
  const ClockEstimate now = estimate_->at(as_seconds(heard_.back().sent_ns - stretch.first_sent_ns));
  state.drift_ppm = now.drift * 1e6;
  state.drift_sd_ppm = std::sqrt(now.drift_var) * 1e6;
  state.offset_s = as_seconds(stretch.origin_ns) + now.ahead_s;
  state.offset_sd_s = std::sqrt(now.ahead_var_s2);
  state.suspect = heard_.size() >= kFewestClockPoints &&
                  std::abs(*state.drift_ppm) - 3.0 * state.drift_sd_ppm > kPlausibleDrift * 1e6;
  return state;
}

bool DeviceClock::slept_within(std::int64_t from_device_ns, std::int64_t to_device_ns) const {
  return std::any_of(sleeps_.begin(), sleeps_.end(), [&](const auto& sleep) {
    return sleep.first < to_device_ns && sleep.second > from_device_ns;
  });
}

}  // namespace strobe::host
