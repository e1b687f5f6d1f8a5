// Every port of the firmware's loop on a virtual clock: time passes only in wait(), in spins and a little
// with each reading, so that a shot of half a second takes a millisecond. Records every call; sensors answer
// flashes; the machine can be frozen. Allocates nothing after construction as long as its records suffice.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <set>
#include <vector>

#include "firmware/core/sequencer.hpp"

namespace strobe::testing {

using namespace strobe::firmware;  // NOLINT: it stands in for the firmware's ports

class VirtualRig final : public Clock,
                         public OutputLines,
                         public EdgeSource,
                         public EventSink,
                         public CommandSource {
 public:
  struct Set {
    MonoTime time;
    Output output;
    bool active;
    Lamps lamps = Lamps::both;  ///< of Output::strobes
  };

  explicit VirtualRig(std::size_t max_flashes = 400, std::size_t record_count = 16) : records_(record_count) {
    for (ShotRecord& record : records_) record.flashes.reserve(max_flashes);
    sets.reserve(20'000);
    events.reserve(40'000);
    statuses.reserve(10'000);
    shots.reserve(record_count);
    pending_.reserve(10'000);
  }

  firmware::Ports ports(firmware::ScheduledOutputs& outputs) { return {*this, outputs, *this, *this, *this}; }

  // What the rig does
  // -------------------------------------------------------------------------------------------
  MonoTime time = from_ns(5'000'000'000);
  bool key = true, estop = false, levels_readable = true, edges_readable = true;
  bool journal = true;
  std::int32_t last_number = std::numeric_limits<std::int32_t>::max();  ///< that is set aside
  bool reuses_records = false;  ///< each shot gets the record of the one before
  Duration set_cost = nanoseconds(300);
  Duration wake_delay{};  ///< whoever sleeps is woken so late
  Duration asleep{};      ///< how long the machine has been suspended in all
  Duration lamp_delay = microseconds(12);
  bool sensor_a_works = true, sensor_b_works = true, xsync_works = false;
  Duration opening_lag = milliseconds(45), closing_lag = milliseconds(45);
  std::set<int> missing_flashes;  ///< by count of lamp pulses since the start
  std::function<bool(Output, bool)> set_succeeds = [](Output, bool) { return true; };

  // What was recorded
  // -------------------------------------------------------------------------------------------
  std::vector<Set> sets;
  std::vector<Event> events;
  std::vector<LoopStatus> statuses;
  std::vector<ShotRecord*> shots;
  std::size_t flushed = 0;  ///< events and statuses that the publisher was woken for
  Duration slept{};
  std::int64_t lost = 0, kernel_lost = 0;

  /// The machine stands still from then on, for so long.
  void freeze(MonoTime when, Duration how_long) {
    freezes_.push_back({when, how_long});
    std::sort(freezes_.begin(), freezes_.end(),
              [](const Freeze& a, const Freeze& b) { return a.when < b.when; });
  }
  /// An edge in the future; key and e-stop change their level with it.
  void schedule(Edge edge) {
    pending_.insert(std::upper_bound(pending_.begin(), pending_.end(), edge,
                                     [](const Edge& a, const Edge& b) { return a.time < b.time; }),
                    edge);
  }
  void schedule_command(MonoTime when, const Command& command) { commands_.push_back({when, command}); }

  const Event* find(EventKind kind, std::size_t nth = 0) const {
    for (const Event& event : events)
      if (event.kind == kind && nth-- == 0) return &event;
    return nullptr;
  }
  std::size_t count(EventKind kind) const {
    return static_cast<std::size_t>(std::count_if(events.begin(), events.end(),
                                                  [kind](const Event& event) { return event.kind == kind; }));
  }
  /// Instants at which the output was made active (or inactive).
  std::vector<MonoTime> instants(Output output, bool active = true) const {
    std::vector<MonoTime> result;
    bool level = false;
    for (const Set& set : sets) {
      if (set.output != output) continue;
      if (set.active != level && set.active == active) result.push_back(set.time);
      level = set.active;
    }
    return result;
  }
  bool level_of(Output output) const {
    for (auto it = sets.rbegin(); it != sets.rend(); ++it)
      if (it->output == output) return it->active;
    return false;
  }
  bool all_inactive() const {
    return !level_of(Output::trigger) && !level_of(Output::strobes) && !level_of(Output::shutter);
  }

  // Ports
  // -------------------------------------------------------------------------------------------------------
  MonoTime now() noexcept override {
    pass(nanoseconds(20));
    return time;
  }
  MonoTime spin_until(MonoTime instant) noexcept override {
    if (instant > time) pass(instant - time);
    pass(nanoseconds(30));
    return time;
  }
  Duration suspended() noexcept override { return asleep; }
  bool set(Output output, bool active) noexcept override { return drive(output, active, Lamps::both); }
  bool set_lamps(Lamps lamps) noexcept override { return drive(Output::strobes, true, lamps); }
  std::optional<std::size_t> wait(MonoTime until, std::span<Edge> edges) noexcept override {
    const MonoTime wake = next_input(until);
    if (wake > time) {
      slept = slept + (wake - time);
      pass(wake - time + wake_delay);
    }
    return take(edges);
  }
  std::optional<std::size_t> poll(MonoTime until, std::span<Edge> edges) noexcept override {
    const MonoTime end = next_input(until);
    if (end > time) pass(end - time);
    return take(edges);
  }
  std::optional<bool> level(Input input) noexcept override {
    if (!levels_readable) return std::nullopt;
    bool key_now = key, estop_now = estop;
    for (const Edge& edge : pending_) {  // the line has changed although its edge was not read yet
      if (edge.time > time) break;
      if (edge.input == Input::key) key_now = edge.active;
      if (edge.input == Input::estop) estop_now = edge.active;
    }
    return input == Input::key ? key_now : input == Input::estop ? estop_now : false;
  }
  std::int64_t overflows() const noexcept override { return lost; }
  std::int64_t kernel_overflows() const noexcept override { return kernel_lost; }
  void event(const Event& event) noexcept override { events.push_back(event); }
  void status(const LoopStatus& status) noexcept override { statuses.push_back(status); }
  ShotRecord* free_record() noexcept override {
    if (reuses_records) return records_.data();
    return shots.size() < records_.size() ? &records_[shots.size()] : nullptr;
  }
  bool shot_done(ShotRecord* record) noexcept override {
    shots.push_back(record);
    return true;
  }
  void flush() noexcept override { flushed = events.size() + statuses.size(); }
  bool journal_ok() const noexcept override { return journal; }
  std::int32_t shot_id_limit() const noexcept override { return last_number; }
  bool pop(Command& command) noexcept override {
    for (auto it = commands_.begin(); it != commands_.end(); ++it) {
      if (it->when > time) continue;
      command = it->command;
      commands_.erase(it);
      return true;
    }
    return false;
  }

 private:
  struct Freeze {
    MonoTime when;
    Duration how_long{};
  };
  struct Timed {
    MonoTime when;
    Command command;
  };

  /// Of an edge or a command, at the latest `until`.
  MonoTime next_input(MonoTime until) const noexcept {
    if (!pending_.empty()) until = std::min(until, pending_.front().time);
    for (const Timed& command : commands_) until = std::min(until, command.when);
    return until;
  }
  std::optional<std::size_t> take(std::span<Edge> edges) noexcept {
    pass(microseconds(3));  // a turn takes its time
    if (!edges_readable) return std::nullopt;
    std::size_t count = 0;
    while (count < edges.size() && !pending_.empty() && pending_.front().time <= time) {
      edges[count++] = pending_.front();
      apply(pending_.front());
      pending_.erase(pending_.begin());
    }
    return count;
  }
  void pass(Duration duration) noexcept {
    time = time + duration;
    while (!freezes_.empty() && freezes_.front().when <= time) {
      time = std::max(time, freezes_.front().when + freezes_.front().how_long);
      freezes_.erase(freezes_.begin());
    }
  }
  void apply(const Edge& edge) noexcept {
    if (edge.input == Input::key) key = edge.active;
    if (edge.input == Input::estop) estop = edge.active;
  }
  bool drive(Output output, bool active, Lamps lamps) noexcept {
    const bool was = level_of(output), done = set_succeeds(output, active);
    if (done) sets.push_back({time, output, active, lamps});
    pass(set_cost);
    if (done && output == Output::strobes && active && !was) flash(lamps);
    if (done && output == Output::shutter && active != was) move_shutter(active);
    return done;
  }
  void move_shutter(bool open) noexcept {
    if (xsync_works) schedule({Input::xsync, sets.back().time + (open ? opening_lag : closing_lag), open});
  }
  void flash(Lamps lamps) noexcept {
    const int index = flashes_++;
    if (missing_flashes.count(index) != 0) return;
    const MonoTime seen = sets.back().time + lamp_delay;
    if (sensor_a_works && has_a(lamps)) schedule({Input::sensor_a, seen, true});
    if (sensor_b_works && has_b(lamps)) schedule({Input::sensor_b, seen, true});
  }

  std::vector<ShotRecord> records_;
  std::vector<Freeze> freezes_;
  std::vector<Edge> pending_;
  std::vector<Timed> commands_;
  int flashes_ = 0;
};

/// The rig as shipped, without a file: every line but the X-sync fitted, the numbers of firmware/rig.toml.
inline Rig shipped_rig() {
  Rig rig;
  rig.file_name = "rig.toml";
  for (LineConfig& line : rig.lines) line.fitted = true;
  rig.line(Line::xsync).fitted = false;
  rig.plan.period = microseconds(3000);
  rig.plan.exposure = milliseconds(500);
  rig.plan.impact_at = milliseconds(250);
  return rig;
}

}  // namespace strobe::testing
