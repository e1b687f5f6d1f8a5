#include "host/clock/device_clock.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>

namespace strobe::host {

struct Heartbeat {
  MonoTime sent;
  HostTime heard;
  /// This machine's clock less the firmware's, with the delay.
  Duration offset() const { return heard.time_since_epoch() - sent.time_since_epoch(); }
};

/// offset = at_origin + drift * (sent - origin), seconds
struct Line {
  double at_origin_s = 0.0;
  double drift = 0.0;
};

/// When a message was sent, and its offset, seconds after the segment's first.
struct Point {
  double sent_s = 0.0, offset_s = 0.0;
};

namespace {

// Longer, and the crystals' wander would count.
constexpr Duration kWindow = std::chrono::minutes{2};
constexpr std::size_t kMaxHeard = 400;
// Before, the fastest message so far stands in for the line.
constexpr std::size_t kMinForLine = 40;
// A message that comes earlier than this was not sent by the clock that is known here.
constexpr double kTooEarly_s = 0.005;
// Heartbeats that are all late by as much as this, and by the same, are not late: the clock was stopped.
constexpr double kTooLate_s = 0.25;
constexpr double kAlike_s = 0.05;
constexpr std::size_t kLateInARow = 8;
constexpr std::size_t kMaxKept = 64;
// Kernels discipline a clock by 500 ppm at most; two may be disciplined.
constexpr double kPlausibleDrift = 1.1e-3;

double left_turn(const Point& a, const Point& b, const Point& c) {
  return (b.sent_s - a.sent_s) * (c.offset_s - a.offset_s) -
         (b.offset_s - a.offset_s) * (c.sent_s - a.sent_s);
}

/// The edge of the lower convex hull over the points' mean. Points in the order of their sending, two at
/// least.
Line lower_envelope(const std::vector<Point>& points) {
  double mean_s = 0.0;
  std::vector<Point> hull;
  for (const Point& point : points) {
    mean_s += point.sent_s / static_cast<double>(points.size());
    while (hull.size() >= 2 && left_turn(hull[hull.size() - 2], hull.back(), point) <= 0.0) hull.pop_back();
    hull.push_back(point);
  }
  assert(hull.size() >= 2);
  std::size_t right = 1;
  while (right + 1 < hull.size() && hull[right].sent_s < mean_s) ++right;
  const Point &a = hull[right - 1], &b = hull[right];
  assert(a.sent_s < b.sent_s);
  const double drift = (b.offset_s - a.offset_s) / (b.sent_s - a.sent_s);
  return {a.offset_s - drift * a.sent_s, drift};
}

}  // namespace

class ClockRelation {
 public:
  bool may_hold_for(const DeviceReading& device, HostTime heard) const;
  void on_heartbeat(const DeviceReading& device, HostTime heard);

  // After the first heartbeat:
  HostTime local(MonoTime device) const;
  ClockState state() const;
  bool suspended_within(MonoTime from, MonoTime to) const;

  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }

 private:
  /// As long as one line holds.
  struct Segment {
    MonoTime first_sent;
    Duration origin{};  ///< offset of the first: numbers are kept relative to it
    std::int64_t heartbeats = 0;
    double min_offset_s = 0.0;  ///< stands in for the line
    std::optional<Line> line;
  };

  double offset_s(const Segment& segment, MonoTime sent) const;
  double lateness_s(const Heartbeat& heartbeat) const;
  void begin(const Heartbeat& heartbeat);
  void add(const Heartbeat& heartbeat);
  bool earlier_than_any(const Heartbeat& heartbeat) const;
  bool broken_by(const Heartbeat& heartbeat);

  ClockStepDetector<MonoTime> device_watch_;
  std::deque<Heartbeat> heartbeats_;  ///< of the last segment, within the window
  std::vector<Heartbeat> late_;       ///< in a row, by about the same: the relation may have broken
  std::vector<Segment> segments_;
  std::vector<std::pair<MonoTime, MonoTime>> sleeps_;  ///< instants around each
  std::vector<std::string> notifications_;
};

double ClockRelation::offset_s(const Segment& segment, MonoTime sent) const {
  if (!segment.line) return segment.min_offset_s;
  return segment.line->at_origin_s + segment.line->drift * to_seconds(sent - segment.first_sent);
}

double ClockRelation::lateness_s(const Heartbeat& heartbeat) const {
  const Segment& segment = segments_.back();
  return to_seconds(heartbeat.offset() - segment.origin) - offset_s(segment, heartbeat.sent);
}

/// Whether a heartbeat may be of this very clock, going on: a clock that was started anew begins below, any
/// other machine's gives another offset.
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
  if (change) std::ranges::move(describe(*change, "the rig's computer"), std::back_inserter(notifications_));
  const bool slept = change && change->suspended != Duration{};
  if (slept) sleeps_.emplace_back(before, heartbeat.sent);
  if (sleeps_.size() > kMaxKept) sleeps_.erase(sleeps_.begin());
  if (heartbeats_.empty() || slept) return begin(heartbeat);
  if (!broken_by(heartbeat)) return add(heartbeat);
  notifications_.push_back(
      "the rig's clock no longer agrees with this computer's; the two are compared anew");
  const std::vector<Heartbeat> kept = std::exchange(late_, {});
  begin(kept.empty() ? heartbeat : kept.front());
  for (std::size_t i = 1; i < kept.size(); ++i) add(kept[i]);
}

/// Than the latest heartbeats and any plausible drift allow: of forty some were not late. The line alone
/// does not show it: a young one may be of late heartbeats.
bool ClockRelation::earlier_than_any(const Heartbeat& heartbeat) const {
  const std::size_t recent = std::min(heartbeats_.size(), kMinForLine);
  const double allowed_s = recent < kMinForLine ? kTooLate_s : kTooEarly_s;
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
  segments_.push_back({.first_sent = heartbeat.sent, .origin = heartbeat.offset(), .line = {}});
  if (segments_.size() > kMaxKept) segments_.erase(segments_.begin());
  add(heartbeat);
}

void ClockRelation::add(const Heartbeat& heartbeat) {
  assert(heartbeats_.empty() || heartbeats_.back().sent < heartbeat.sent);
  heartbeats_.push_back(heartbeat);
  while (heartbeats_.size() > kMaxHeard || heartbeat.sent - heartbeats_.front().sent > kWindow)
    heartbeats_.pop_front();
  Segment& segment = segments_.back();
  ++segment.heartbeats;
  segment.min_offset_s = std::min(segment.min_offset_s, to_seconds(heartbeat.offset() - segment.origin));
  if (heartbeats_.size() < kMinForLine) return;
  std::vector<Point> points;
  for (const Heartbeat& heard : heartbeats_)
    points.push_back(
        {to_seconds(heard.sent - segment.first_sent), to_seconds(heard.offset() - segment.origin)});
  segment.line = lower_envelope(points);
}

HostTime ClockRelation::local(MonoTime device) const {
  assert(!segments_.empty());
  auto segment = segments_.rbegin();
  while (std::next(segment) != segments_.rend() && device < segment->first_sent) ++segment;
  return HostTime{device.time_since_epoch() + segment->origin + from_seconds(offset_s(*segment, device))};
}

ClockState ClockRelation::state() const {
  ClockState state;
  const Segment& segment = segments_.back();
  state.heartbeats = segment.heartbeats;
  state.latency_s = lateness_s(heartbeats_.back());
  for (const Heartbeat& heartbeat : heartbeats_)
    state.worst_latency_s = std::max(state.worst_latency_s, lateness_s(heartbeat));
  if (!segment.line) return state;
  state.drift_ppm = segment.line->drift * 1e6;
  state.suspect = std::abs(segment.line->drift) > kPlausibleDrift;
  return state;
}

bool ClockRelation::suspended_within(MonoTime from, MonoTime to) const {
  return std::ranges::any_of(sleeps_,
                             [&](const auto& sleep) { return sleep.first < to && sleep.second > from; });
}

const DeviceClock::Boot* DeviceClock::find(std::int64_t boot_id) const {
  const auto found = std::ranges::find(boots_, boot_id, &Boot::id);
  return found == boots_.end() ? nullptr : &*found;
}

DeviceClock::Boot DeviceClock::first_heard(std::int64_t boot_id, const DeviceReading& device,
                                           HostTime heard) const {
  const bool same_clock = !boots_.empty() && boots_.back().relation->may_hold_for(device, heard);
  return {boot_id, same_clock ? boots_.back().relation : std::make_shared<ClockRelation>()};
}

void DeviceClock::on_heartbeat(std::int64_t boot_id, const DeviceReading& device, HostTime heard) {
  if (!find(boot_id)) {
    boots_.push_back(first_heard(boot_id, device, heard));
    if (boots_.size() > kMaxBoots) boots_.pop_front();
  }
  ClockRelation& relation = *find(boot_id)->relation;
  relation.on_heartbeat(device, heard);
  std::ranges::move(relation.take_notifications(), std::back_inserter(notifications_));
}

void DeviceClock::on_local(const HostReading& local) {
  if (const auto change = local_watch_.on_reading(local))
    std::ranges::move(describe(*change, "this computer"), std::back_inserter(notifications_));
}

std::optional<HostTime> DeviceClock::local(std::int64_t boot_id, MonoTime device) const {
  const Boot* boot = find(boot_id);
  return boot ? std::optional(boot->relation->local(device)) : std::nullopt;
}

ClockState DeviceClock::state() const {
  return boots_.empty() ? ClockState() : boots_.back().relation->state();
}

bool DeviceClock::suspended_within(std::int64_t boot_id, MonoTime from, MonoTime to) const {
  const Boot* boot = find(boot_id);
  return boot && boot->relation->suspended_within(from, to);
}

}  // namespace strobe::host
