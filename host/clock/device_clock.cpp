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
constexpr std::size_t kMostPoints = 400;
constexpr std::size_t kMostKept = 64;
constexpr std::int64_t kFitEvery_ns = 5'000'000'000;
// Kernels discipline a clock by 500 ppm at most; two may be disciplined.
constexpr double kPlausibleDrift = 1.1e-3;
// What a relation too young for a drift may be wrong by.
constexpr double kUnknownDrift = 1e-3;
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
  const bool older = !window_.empty() && heartbeat.sent_ns <= window_.back().sent_ns;
  if (older && !anew) return;  // overtaken on the way, or doubled
  const std::int64_t before_ns = window_.empty() ? heartbeat.sent_ns : window_.back().sent_ns;
  if (older) device_watch_.forget();
  const auto change = device_watch_.on_reading(device);
  if (change) notice_changes(*change, "the firmware's machine");
  const bool slept = change && change->slept_ns != 0;
  if (slept) sleeps_.emplace_back(before_ns, heartbeat.sent_ns);
  if (sleeps_.size() > kMostKept) sleeps_.erase(sleeps_.begin());
  if (window_.empty() || older || slept) return begin(heartbeat);
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

bool DeviceClock::broken_by(const Heartbeat& heartbeat) {
  const double late_s = lateness_s(heartbeat);
  const double doubt_s =
      kTooEarly_s + (stretches_.back().line
                         ? 0.0
                         : kUnknownDrift * as_seconds(heartbeat.sent_ns - stretches_.back().first_sent_ns));
  if (late_s < -doubt_s) {
    late_.clear();
    return true;
  }
  const bool alike = late_.empty() || std::abs(late_s - lateness_s(late_.front())) < kAlike_s;
  if (late_s < kTooLate_s || !alike) late_.clear();
  if (late_s >= kTooLate_s) late_.push_back(heartbeat);
  return late_.size() >= kLateInARow;
}

void DeviceClock::begin(const Heartbeat& heartbeat) {
  window_.clear();
  late_.clear();
  Stretch stretch;
  stretch.first_sent_ns = heartbeat.sent_ns;
  stretch.origin_ns = heartbeat.heard_ns - heartbeat.sent_ns;
  stretches_.push_back(stretch);
  if (stretches_.size() > kMostKept) stretches_.erase(stretches_.begin());
  add(heartbeat);
}

void DeviceClock::add(const Heartbeat& heartbeat) {
  window_.push_back(heartbeat);
  while (window_.size() > kMostPoints || heartbeat.sent_ns - window_.front().sent_ns > kWindow_ns)
    window_.pop_front();
  Stretch& stretch = stretches_.back();
  ++stretch.heartbeats;
  const double ahead_s = as_seconds(heartbeat.heard_ns - heartbeat.sent_ns - stretch.origin_ns);
  stretch.least_ahead_s = std::min(stretch.least_ahead_s, ahead_s);
  if (stretch.line && heartbeat.sent_ns - fitted_ns_ < kFitEvery_ns) return;
  if (window_.size() < kFewestClockPoints) return;
  fitted_ns_ = heartbeat.sent_ns;
  if (auto line = fit_clock(points())) stretch.line = *line;
}

std::vector<ClockPoint> DeviceClock::points() const {
  const Stretch& stretch = stretches_.back();
  std::vector<ClockPoint> points;
  for (const Heartbeat& heartbeat : window_) {
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

ClockState DeviceClock::state() {
  ClockState state;
  if (stretches_.empty()) return state;
  Stretch& stretch = stretches_.back();
  state.heartbeats = stretch.heartbeats;
  state.latency_s = lateness_s(window_.back());
  for (const Heartbeat& heartbeat : window_)
    state.worst_latency_s = std::max(state.worst_latency_s, lateness_s(heartbeat));
  if (!stretch.line) return state;
  if (fitted_ns_ != sds_fitted_ns_) {
    sds_fitted_ns_ = fitted_ns_;
    stretch.line = fit_clock(points());
    add_covariance(*stretch.line, points());
  }
  const double newest_s = as_seconds(window_.back().sent_ns - stretch.first_sent_ns);
  state.drift_ppm = stretch.line->drift * 1e6;
  state.drift_sd_ppm = std::sqrt(stretch.line->drift_var) * 1e6;
  state.offset_s = as_seconds(stretch.origin_ns) + stretch.line->ahead_s(newest_s);
  state.offset_sd_s = stretch.line->sd_s(newest_s);
  state.suspect = std::abs(*state.drift_ppm) - 3.0 * state.drift_sd_ppm > kPlausibleDrift * 1e6;
  return state;
}

bool DeviceClock::slept_within(std::int64_t from_device_ns, std::int64_t to_device_ns) const {
  return std::any_of(sleeps_.begin(), sleeps_.end(), [&](const auto& sleep) {
    return sleep.first < to_device_ns && sleep.second > from_device_ns;
  });
}

}  // namespace strobe::host
