#include "firmware/core/shot_player.hpp"

#include <algorithm>
#include <cassert>

namespace strobe::firmware {

namespace {

Line line_of(Lamps lamps) {
  return lamps == Lamps::a ? Line::strobe_a : lamps == Lamps::b ? Line::strobe_b : Line::none;
}

}  // namespace

ShotPlayer::ShotPlayer(const Rig& rig, Clock& clock, EdgeSource& edges, EventSink& sink, Interlock& interlock,
                       ScheduledOutputs& outputs, const Tick& tick)
    : rig_(rig),
      clock_(clock),
      edges_(edges),
      sink_(sink),
      interlock_(interlock),
      outputs_(outputs),
      tick_avoidance_(tick),
      last_flash_{clock.now(), clock.now()} {
  schedule_.reserve(rig.lamps.max_flashes);
}

void ShotPlayer::report(EventKind kind, Line line, int level, const Issue& issue,
                        std::int32_t flash_index) noexcept {
  Event event;
  event.kind = kind;
  event.line = line;
  event.level = static_cast<std::int8_t>(level);
  event.shot_id = record_->shot_id;
  event.flash_index = flash_index;
  event.device_time = issue.end;
  event.commanded = issue.commanded;
  event.issue_start = issue.start;
  event.issue_end = issue.end;
  sink_.event(event);
}

void ShotPlayer::report(EventKind kind, MonoTime time, const ShortText& detail, MonoTime commanded) noexcept {
  Event event;
  event.kind = kind;
  event.shot_id = record_->shot_id;
  event.device_time = time;
  event.commanded = commanded;
  event.detail = detail;
  sink_.event(event);
}

void ShotPlayer::begin(const Command& fire, std::int32_t shot_id, ShotRecord& record) noexcept {
  assert(phase_ == Phase::idle && interlock_.state() == State::firing);
  assert(shot_id == interlock_.shot_id() && !outputs_.any_active());
  const MonoTime now = clock_.now();
  record_ = &record;
  record.shot_id = shot_id;
  record.host_id = fire.host_id;
  record.command_id = fire.command_id;
  record.plan = fire.plan;
  if (record.plan.impact_at == Duration{}) record.plan.impact_at = rig_.plan.impact_at;
  record.shutter_on = record.shutter_off = record.shutter_open = record.shutter_close = kNoTime;
  record.trigger = record.gate = kNoTime;
  record.abort_reason = ShortText();
  overflows_before_ = sink_.overflows();
  kernel_overflows_before_ = edges_.kernel_overflows();
  build_schedule(record.plan, rig_, schedule_);
  assert(interlock_.trigger_pending() == !record.plan.dry);
  record.start = now + lead();
  record.start = record.start + tick_avoidance_.delay(record.start, schedule_);
  edge_assignment_.open(record, schedule_.shortest_interval);
  for (const PlannedPulse& pulse : schedule_.pulses) {
    if (pulse.output == Output::strobes) edge_assignment_.plan(at(pulse.at), pulse.lamps);
  }
  gate_counts_from_ = kNoTime;
  shutter_seen_open_ = shutter_seen_closed_ = false;
  phase_ = Phase::playing;
  report(EventKind::shot_started, now, record.plan.dry ? "dry" : "");
  outputs_.begin(schedule_, record.start, *this);
}

Duration ShotPlayer::lead() const noexcept { return std::max(kLead, outputs_.lead(schedule_)); }

MonoTime ShotPlayer::next_due() const noexcept {
  switch (phase_) {
    case Phase::idle:
      return kNoDeadline;
    case Phase::playing: {
      const MonoTime issue = outputs_.next_due();
      return issue == kNoDeadline || awaits_gate() ? std::min(issue, at(schedule_.exposure_end)) : issue;
    }
    case Phase::closing:
      return outputs_.any_active() ? std::max(closes_at_, outputs_.next_due()) : closes_at_;
    case Phase::handing_over:
      return clock_.now() + milliseconds(1);
  }
  return kNoDeadline;
}

void ShotPlayer::run_due() noexcept {
  if (phase_ == Phase::playing || phase_ == Phase::closing) outputs_.run(*this);
  end_if_over();
}

Duration ShotPlayer::recharge_left(const ShotPlan& plan) noexcept {
  assert(!busy());
  build_schedule(plan, rig_, schedule_);
  const MonoTime start = clock_.now() + lead();
  const auto left = [&](Duration at, Lamps lamps) {
    Duration longest{};
    for (std::size_t lamp = 0; lamp < last_flash_.size(); ++lamp) {
      if (lamp == 0 ? has_a(lamps) : has_b(lamps))
        longest = std::max(longest, last_flash_[lamp] + rig_.lamps.min_period - (start + at));
    }
    return longest;
  };
  if (schedule_.gated) return left(schedule_.exposure_begin, Lamps::both);
  Duration longest{};
  for (const PlannedPulse& pulse : schedule_.pulses) {
    if (pulse.output == Output::strobes) longest = std::max(longest, left(pulse.at, pulse.lamps));
  }
  return longest;
}

bool ShotPlayer::lamps_recharged(const PlannedPulse& pulse, MonoTime now) noexcept {
  for (std::size_t lamp = 0; lamp < last_flash_.size(); ++lamp) {
    const bool flashes = lamp == 0 ? has_a(pulse.lamps) : has_b(pulse.lamps);
    const Duration least = flashes ? rig_.lamps.min_period : min_flash_interval(rig_);
    const Duration gap = now - last_flash_[lamp];
    // A plan at the lamps' shortest period must survive the jitter that is tolerated in each flash.
    if (gap + rig_.tolerance.late >= least) continue;
    ShortText why("flash ");
    why.append(pulse.flash_index)
        .append(" would have come ")
        .append(gap / microseconds(1))
        .append(" us after the one before");
    abort(why);
    return false;
  }
  return true;
}

bool ShotPlayer::allows(const PlannedPulse& pulse, MonoTime now) noexcept {
  if (phase_ != Phase::playing) return false;
  if (pulse.output == Output::strobes) return lamps_recharged(pulse, now);
  if (pulse.output != Output::trigger) return true;
  const char* why = trigger_withheld();
  if (why != nullptr) abort(why);
  return why == nullptr;
}

/// Null: the trigger may be pulled, once.
const char* ShotPlayer::trigger_withheld() noexcept {
  const auto key = edges_.level(Input::key);
  const auto estop = edges_.level(Input::estop);
  if (!key || !estop) return "key or e-stop could not be read before the trigger";
  if (!*key) return "the key is off";
  if (*estop) return "the e-stop is pressed";
  if (!interlock_.release_trigger(record_->shot_id)) return "the interlock withheld the trigger";
  assert(!record_->plan.dry && !known(record_->trigger) && !interlock_.trigger_pending());
  return nullptr;
}

void ShotPlayer::switched_on(const PlannedPulse& pulse, const Issue& issue) noexcept {
  switch (pulse.output) {
    case Output::strobes:
      assert(pulse.flash_index >= 0 && pulse.flash_index < schedule_.flash_count);
      // Wherever in the call the line changed, the lamp has not flashed after it.
      if (has_a(pulse.lamps)) last_flash_[0] = issue.end;
      if (has_b(pulse.lamps)) last_flash_[1] = issue.end;
      edge_assignment_.issued(pulse.flash_index, issue.start, issue.end);
      report(EventKind::flash, line_of(pulse.lamps), 1, issue, pulse.flash_index);
      break;
    case Output::trigger:
      record_->trigger = issue.end;
      gate_counts_from_ = issue.end;
      report(EventKind::trigger, Line::trigger, 1, issue);
      break;
    case Output::shutter:
      assert(!known(record_->shutter_on));
      record_->shutter_on = issue.end;
      record_->shutter_open = issue.end + rig_.shutter.lag;
      if (record_->plan.dry) gate_counts_from_ = issue.end;  // a hand in the gate stands in for the ball
      report(EventKind::shutter, Line::shutter, 1, issue);
      break;
  }
  if (issue.done) return;
  abort(pulse.output == Output::strobes   ? "the lamps' lines could not be set"
        : pulse.output == Output::trigger ? "the trigger's line could not be set"
                                          : "the shutter's line could not be set");
}

void ShotPlayer::switched_off(Output output, const Issue& issue, Duration on_time) noexcept {
  if (output == Output::shutter) {
    record_->shutter_off = issue.end;
    record_->shutter_close = issue.end + rig_.shutter.lag;
    report(EventKind::shutter, Line::shutter, 0, issue);
  } else if (output == Output::trigger) {
    report(EventKind::trigger, Line::trigger, 0, issue);
  }
  if (!issue.done) return abort("an output could not be switched off");
  const Duration longest = output == Output::strobes   ? rig_.lamps.max_on
                           : output == Output::trigger ? rig_.machine.max_on
                                                       : rig_.shutter.max_open;
  if (on_time <= longest + rig_.tolerance.late) return;
  ShortText why(output == Output::strobes   ? "the lamps' lines were"
                : output == Output::trigger ? "the trigger was"
                                            : "the shutter was");
  abort(why.append(" on for ").append(on_time / microseconds(1)).append(" us"), issue.commanded);
}

void ShotPlayer::edge(const Edge& edge) noexcept {
  if (busy()) outputs_.tell(*this);  // a gate's edge counts after the trigger
  if (busy() && edge.input == Input::xsync) return xsync(edge);
  if (!busy() || !edge.active) return;
  Event event;
  event.shot_id = record_->shot_id;
  event.device_time = edge.time;
  event.level = 1;
  if (edge.input == Input::gate) {
    event.kind = EventKind::gate;
    event.line = Line::gate;
    sink_.event(event);
    gate(edge.time);
    return;
  }
  event.kind = EventKind::sensor;
  event.line = edge.input == Input::sensor_a ? Line::sensor_a : Line::sensor_b;
  sink_.event(event);
  const bool is_a = edge.input == Input::sensor_a;
  edge_assignment_.edge(edge.input, edge.time - (is_a ? rig_.sensors.delay_a : rig_.sensors.delay_b));
}

void ShotPlayer::xsync(const Edge& edge) noexcept {
  Event event;
  event.kind = EventKind::xsync;
  event.line = Line::xsync;
  event.level = edge.active ? 1 : 0;
  event.shot_id = record_->shot_id;
  event.device_time = edge.time;
  sink_.event(event);
  const auto after = [&edge](MonoTime issued) { return known(issued) && edge.time >= issued; };
  // Contacts bounce: the first edge counts, and a closing only once the line is off.
  if (edge.active && !shutter_seen_open_ && after(record_->shutter_on)) {
    shutter_seen_open_ = true;
    record_->shutter_open = edge.time;
  } else if (!edge.active && shutter_seen_open_ && !shutter_seen_closed_ && after(record_->shutter_off)) {
    shutter_seen_closed_ = true;
    record_->shutter_close = edge.time;
    if (phase_ == Phase::closing) closes_at_ = std::min(closes_at_, clock_.now() + kEdgeTimeout);
  }
}

ShutterFeedback ShotPlayer::shutter_feedback() const noexcept {
  if (!rig_.line(Line::xsync).fitted || !known(record_->shutter_on)) return ShutterFeedback::none;
  if (!shutter_seen_open_ || !shutter_seen_closed_) return ShutterFeedback::missing;
  const auto off_by = [this](MonoTime seen, MonoTime issued) {
    const Duration off = seen - issued - rig_.shutter.lag;
    return std::max(off, -off);
  };
  const bool late = off_by(record_->shutter_open, record_->shutter_on) > rig_.shutter.late ||
                    off_by(record_->shutter_close, record_->shutter_off) > rig_.shutter.late;
  return late ? ShutterFeedback::late : ShutterFeedback::seen;
}

void ShotPlayer::close() noexcept {
  assert(phase_ == Phase::playing);
  phase_ = Phase::closing;
  closes_at_ = clock_.now() + kEdgeTimeout;
  if (rig_.line(Line::xsync).fitted && shutter_seen_open_ && !shutter_seen_closed_)
    closes_at_ = std::max(closes_at_, record_->shutter_close + rig_.shutter.late);
}

void ShotPlayer::gate(MonoTime stamp) noexcept {
  assert(!known(record_->trigger) || gate_counts_from_ == record_->trigger);
  const bool is_the_ball = known(gate_counts_from_) && stamp >= gate_counts_from_;
  // Of a shot that is being cut the burst may have begun.
  const bool cutting = phase_ == Phase::closing && outputs_.any_active();
  if ((phase_ != Phase::playing && !cutting) || !is_the_ball || known(record_->gate)) return;
  record_->gate = stamp;
  if (!schedule_.gated) return;
  const Duration first = stamp + record_->plan.gate_delay - record_->start;
  if (first < schedule_.exposure_begin) return abort("the gate was interrupted before the shutter was open");
  if (!add_burst(record_->plan, rig_, first, schedule_)) {
    return abort("the gate was interrupted too late for the burst to end within the exposure");
  }
  const std::size_t first_flash = schedule_.pulses.size() - schedule_.burst.size();
  for (std::size_t k = first_flash; k < schedule_.pulses.size(); ++k)
    edge_assignment_.plan(at(schedule_.pulses[k].at), schedule_.pulses[k].lamps);
  outputs_.add(first_flash);
}

void ShotPlayer::stop(const ShortText& why) noexcept {
  if (phase_ != Phase::playing) return;
  cut_short(why, kNoTime);
  assert(!interlock_.trigger_pending());
}

void ShotPlayer::abort(const ShortText& why, MonoTime late_for) noexcept {
  if (phase_ != Phase::playing) return;
  cut_short(why, late_for);
  interlock_.aborted();
}

void ShotPlayer::cut_short(const ShortText& why, MonoTime late_for) noexcept {
  assert(phase_ == Phase::playing && record_->abort_reason.empty());
  const bool shutter_was_open = outputs_.active(Output::shutter) && known(record_->shutter_on);
  outputs_.cut();  // a failure is the sequencer's to act on
  if (shutter_was_open) {
    record_->shutter_off = clock_.now();
    record_->shutter_close = record_->shutter_off + rig_.shutter.lag;
  }
  record_->abort_reason = why;
  close();
  report(EventKind::shot_aborted, clock_.now(), why, late_for);
}

void ShotPlayer::end_if_over() noexcept {
  if (phase_ == Phase::playing && clock_.now() >= at(schedule_.exposure_end)) {
    if (awaits_gate()) {
      abort("gate never seen");
    } else if (outputs_.all_issued() && !outputs_.any_active()) {
      close();
    }
  }
  const bool inactive = outputs_.broken() || !outputs_.any_active();
  if (phase_ == Phase::closing && inactive && clock_.now() >= closes_at_) {
    if (record_->abort_reason.empty()) report(EventKind::shot_ended, clock_.now(), outputs_.clock_words());
    record_->shutter_feedback = shutter_feedback();
    record_->queue_overflows = sink_.overflows() - overflows_before_;
    record_->kernel_overflows = edges_.kernel_overflows() - kernel_overflows_before_;
    phase_ = Phase::handing_over;
  }
  if (phase_ == Phase::handing_over && sink_.shot_done(record_)) {
    phase_ = Phase::idle;
    interlock_.shot_over();
  }
}

}  // namespace strobe::firmware
