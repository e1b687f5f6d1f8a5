#include "firmware/flash_sequencer/outputs.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace strobe::firmware {

using flash_sequencer::CutCause;
using flash_sequencer::kNoTicks;
using flash_sequencer::Phase;
using flash_sequencer::Refusal;
using flash_sequencer::Request;
using flash_sequencer::Status;
using flash_sequencer::Ticks;
using flash_sequencer::to_frame;

namespace {

/// A train begins so long before its first instant, as no edge can be at its very begin.
constexpr Duration kAhead = microseconds(1);
/// A request of a full frame, its answer, and the turn of the loop between them.
constexpr Duration kRequestTime = milliseconds(4);
/// Of a loop that stands still while it loads, and of frames that are sent again.
constexpr Duration kLoadingMargin = milliseconds(50);
/// START is sent so long before its instant, at the latest.
constexpr Duration kStartTime = milliseconds(2);
/// A sequencer that says nothing for so long while it plays has cut its outputs, or its line is broken.
constexpr Duration kLongestSilence = FlashSequencerLink::kFresh;
/// A shot's last edges have come by then.
constexpr Duration kHeldAfter = milliseconds(1000);
constexpr Duration kAbortAgain = milliseconds(5);

constexpr const char* kWasReset = "the flash sequencer was reset";

constexpr flash_sequencer::Track track_of(Output output) {
  return output == Output::strobes ? flash_sequencer::Track::lamps : flash_sequencer::Track::movers;
}

const char* words_of(CutCause cause) {
  switch (cause) {
    case CutCause::none:
      return "it was not told why";
    case CutCause::key:
      return "the key is off";
    case CutCause::estop:
      return "the e-stop is pressed";
    case CutCause::heartbeat:
      return "strobed's beats did not come";
    case CutCause::abort:
      return "it was asked to";
    case CutCause::underrun:
      return "it could not fetch an edge in time";
    case CutCause::overrun:
      return "the train was not over in time";
  }
  return "";
}

const char* words_of(Refusal refusal) {
  switch (refusal) {
    case Refusal::none:
      return "nothing";
    case Refusal::malformed:
      return "a request that it does not understand";
    case Refusal::wrong_phase:
      return "a request out of turn";
    case Refusal::bad_index:
      return "edges out of order";
    case Refusal::foreign_line:
      return "an edge of the other track";
    case Refusal::delay_too_short:
      return "edges too near to one another";
    case Refusal::train_differs:
      return "a train that is not the one loaded";
    case Refusal::ends_active:
      return "a train that leaves an output active";
    case Refusal::on_too_long:
      return "a pulse that is too long";
    case Refusal::key_off:
      return "to play: the key is off";
    case Refusal::estop_pressed:
      return "to play: the e-stop is pressed";
    case Refusal::no_heartbeat:
      return "to play: strobed's beats did not come";
    case Refusal::wrong_challenge:
      return "to start what it did not arm";
    case Refusal::too_late:
      return "to start: it is too late";
  }
  return "";
}

}  // namespace

FlashSequencerOutputs::FlashSequencerOutputs(const Rig& rig, FlashSequencerLink& link, Clock& clock)
    : link_(link), clock_(clock), limits_(on_time_limits(rig)) {}

Duration FlashSequencerOutputs::lead(const PulseSchedule& schedule) const noexcept {
  constexpr std::size_t kOthers = 8;  // HELLO, LIMITS, RESET, ARM, START; LOADs that are not full
  const std::size_t edges = 2 * (schedule.pulses.size() + schedule.burst.size());
  const auto requests = static_cast<std::int64_t>(edges / flash_sequencer::Load::kMaxEdges + kOthers);
  return requests * kRequestTime + kLoadingMargin;
}

// ---- loading ----

void FlashSequencerOutputs::begin(const PulseSchedule& schedule, MonoTime start,
                                  Listener& listener) noexcept {
  assert(!under_way() && !any_active());
  end();
  schedule_ = &schedule;
  start_ = start;
  link_.hold_clock_relation(start + schedule.exposure_end + kHeldAfter);
  const double drift = link_.clock_relation().drift();
  const bool gated = schedule.gated;
  const bool fits = trains_[0].build(schedule.pulses, Track::movers, kAhead, drift, limits_) &&
                    trains_[1].build(gated ? schedule.burst : schedule.pulses, Track::lamps,
                                     gated ? Duration{} : kAhead, drift, limits_);
  ask(Step::hello, to_frame(Request::hello));
  if (!fits) give_up(listener, "the flash sequencer has no room for so long a train");
}

void FlashSequencerOutputs::ask(Step step, const flash_sequencer::Frame& request) noexcept {
  step_ = step;
  link_.ask(request);
}

void FlashSequencerOutputs::go_on(const Status& answer, Listener& listener) noexcept {
  if (answer.refusal == Refusal::too_late)
    return give_up(listener, "the flash sequencer was not loaded in time", start_);
  if (answer.refusal != Refusal::none)
    return give_up(listener, ShortText("the flash sequencer refused ").append(words_of(answer.refusal)));
  switch (step_) {
    case Step::hello: {
      flash_sequencer::Limits limits = limits_;
      for (std::uint32_t& max_on_us : limits.max_on_us)
        if (max_on_us != 0) ++max_on_us;  // edges may have been moved apart
      return ask(Step::limits, to_frame(limits));
    }
    case Step::limits:
      if (answer.phase == Phase::cut) return ask(Step::reset, to_frame(Request::reset));
      return load(Track::movers, 0);
    case Step::reset:
      return load(Track::movers, 0);
    case Step::load:
      return loaded();
    case Step::arm:
      return start(answer.challenge, listener);
    case Step::start:
      step_ = Step::playing;
      return;
    case Step::idle:
    case Step::playing:
    case Step::cutting:
      return;
  }
}

/// The edges from that one on that one request can carry.
void FlashSequencerOutputs::load(Track track, std::size_t first) noexcept {
  const auto edges = train(track).edges().subspan(first);
  asked_to_load_.track = track;
  asked_to_load_.first = static_cast<std::uint16_t>(first);
  asked_to_load_.count = static_cast<std::uint16_t>(std::min(edges.size(), flash_sequencer::Load::kMaxEdges));
  std::copy_n(edges.begin(), asked_to_load_.count, asked_to_load_.edges.begin());
  ask(Step::load, to_frame(asked_to_load_));
}

void FlashSequencerOutputs::loaded() noexcept {
  const std::size_t next = std::size_t{asked_to_load_.first} + asked_to_load_.count;
  if (next < train(asked_to_load_.track).edges().size()) return load(asked_to_load_.track, next);
  if (asked_to_load_.track == Track::movers) return load(Track::lamps, 0);
  arm();
}

void FlashSequencerOutputs::arm() noexcept {
  flash_sequencer::Arm arm;
  const auto movers = train(Track::movers).edges(), lamps = train(Track::lamps).edges();
  arm.edges = {static_cast<std::uint16_t>(movers.size()), static_cast<std::uint16_t>(lamps.size())};
  arm.crc = flash_sequencer::train_crc(movers, lamps);
  arm.gated = schedule_->gated ? 1 : 0;
  ask(Step::arm, to_frame(arm));
}

/// False: something was cut.
bool FlashSequencerOutputs::all_allowed(Listener& listener) noexcept {
  const auto allowed = [&](const PlannedPulse& pulse, Duration at) {
    if (!listener.allows(pulse, start_ + at) && step_ == Step::arm) cut();
    return step_ == Step::arm;
  };
  for (const PlannedPulse& pulse : schedule_->pulses)
    if (!allowed(pulse, pulse.at)) return false;
  // No earlier than with a gate at its first instant.
  for (const PlannedPulse& pulse : schedule_->burst)
    if (!allowed(pulse, schedule_->exposure_begin + pulse.at - schedule_->burst.front().at)) return false;
  return true;
}

/// A gate counts if the burst is within the exposure then, and comes after the trigger (a dry shot's: the
/// shutter).
flash_sequencer::Start FlashSequencerOutputs::start_request() noexcept {
  const ClockRelation& clocks = link_.clock_relation();
  flash_sequencer::Start start;
  start.at = clocks.to_ticks(start_ - kAhead);
  if (!schedule_->gated || schedule_->burst.empty()) return start;
  const PlannedPulse& first = schedule_->burst.front();
  const PlannedPulse& last = schedule_->burst.back();
  Duration from = schedule_->exposure_begin - first.at;
  for (const PlannedPulse& pulse : schedule_->pulses) from = std::max(from, pulse.at);
  gate_counts_from_ = start_ + from;
  const MonoTime until = start_ + std::max(from, schedule_->exposure_end - last.at - last.width);
  start.gate_from = clocks.to_ticks(gate_counts_from_) - start.at;
  start.gate_until = clocks.to_ticks(until) - start.at;
  return start;
}

void FlashSequencerOutputs::start(std::uint32_t challenge, Listener& listener) noexcept {
  if (!all_allowed(listener)) return;
  flash_sequencer::Start start = start_request();
  start.challenge = challenge;
  asked_to_start_ = true;
  ask(Step::start, to_frame(start));
}

void FlashSequencerOutputs::give_up(Listener& listener, const ShortText& why, MonoTime late_for) noexcept {
  listener.failed(why, late_for);
  if (under_way()) cut();
}

void FlashSequencerOutputs::add(std::size_t first) noexcept { first_of_burst_ = first; }

// ---- playing ----

void FlashSequencerOutputs::tell(Listener& listener) noexcept {
  if (step_ == Step::playing || (step_ == Step::cutting && is_cut()))
    while (tell_next(listener)) continue;
}

void FlashSequencerOutputs::run(Listener& listener) noexcept {
  link_.take();  // a line that is gone is told by the inputs
  look();
  if (failure_ == kWasReset && under_way()) return give_up(listener, kWasReset);
  if (step_ == Step::cutting && is_cut()) {
    if (link_.has_edges()) return;         // one may be the gate's
    while (tell_next(listener)) continue;  // what was played before it was cut
    return end();
  }
  if (!under_way()) return;
  const bool earlier_cut_over = step_ >= Step::load;
  if (earlier_cut_over && link_.status().phase == Phase::cut) {
    ShortText why("the flash sequencer cut the outputs: ");
    return give_up(listener, why.append(words_of(link_.status().cut)));
  }
  const auto answer = link_.take_answer();
  const bool in_time = step_ == Step::start || step_ == Step::playing || clock_.now() < start_ - kStartTime;
  if (!in_time) return give_up(listener, "the flash sequencer was not loaded in time", start_);
  if (answer) {
    go_on(*answer, listener);
  } else {
    link_.ask_again();
  }
  if (step_ == Step::start || step_ == Step::playing) play(listener);
}

void FlashSequencerOutputs::play(Listener& listener) noexcept {
  if (link_.silence() > kLongestSilence) return give_up(listener, "the flash sequencer does not answer");
  if (step_ != Step::playing) return;
  while (tell_next(listener)) continue;
  if (step_ != Step::playing) return;
  if (all_told()) return end();
  if (link_.status().phase != Phase::playing && (!schedule_->gated || first_of_burst_ != kNotAdded))
    give_up(listener, "the flash sequencer did not play the whole train");
}

Ticks FlashSequencerOutputs::begin_of(Track track) const noexcept {
  const Status& status = link_.status();
  return track == Track::lamps && schedule_->gated ? status.burst_started : status.started;
}

/// The next change to be told of that track; null: the sequencer has not played it yet.
const FlashSequencerOutputs::Change* FlashSequencerOutputs::next_played(Track track) const noexcept {
  const auto index = static_cast<std::size_t>(track);
  if (told_[index] == train(track).changes().size() || begin_of(track) == kNoTicks) return nullptr;
  if (track == Track::lamps && schedule_->gated && first_of_burst_ == kNotAdded) return nullptr;
  const Change& change = train(track).changes()[told_[index]];
  return change.edge < link_.status().played[index] ? &change : nullptr;
}

/// In the order of time. False: nothing more, or something was cut.
bool FlashSequencerOutputs::tell_next(Listener& listener) noexcept {
  if (!asked_to_start_ || !link_.clock_relation().known()) return false;
  const Change* mover = next_played(Track::movers);
  const Change* lamp = next_played(Track::lamps);
  if (mover == nullptr && lamp == nullptr) return false;
  const bool movers_first = lamp == nullptr || (mover != nullptr && begin_of(Track::movers) + mover->at <=
                                                                        begin_of(Track::lamps) + lamp->at);
  const Step before = step_;
  const Track track = movers_first ? Track::movers : Track::lamps;
  ++told_[static_cast<std::size_t>(track)];
  tell(movers_first ? *mover : *lamp, track, listener);
  return step_ == before;
}

void FlashSequencerOutputs::tell(const Change& change, Track track, Listener& listener) noexcept {
  const std::size_t first = track == Track::lamps && schedule_->gated ? first_of_burst_ : 0;
  const PlannedPulse& pulse = schedule_->pulses[first + change.pulse];
  const std::size_t output = index_of(pulse.output);
  const MonoTime played = link_.clock_relation().to_time(begin_of(track) + change.at);
  Issue issue{start_ + pulse.at, played, played, true};
  on_[output] = change.on;
  if (change.on) {
    on_at_[output] = change.at;
    listener.switched_on(pulse, issue);
  } else {
    const auto on_ns = static_cast<double>((change.at - on_at_[output]) * flash_sequencer::kTick_ns);
    const Duration on_time{std::llround(on_ns * (1.0 + link_.clock_relation().drift()))};
    issue.commanded += on_time;
    listener.switched_off(pulse.output, issue, on_time);
  }
}

bool FlashSequencerOutputs::all_told() const noexcept {
  return told_[0] == train(Track::movers).changes().size() &&
         told_[1] == train(Track::lamps).changes().size();
}

bool FlashSequencerOutputs::all_issued() const noexcept {
  if (!under_way()) return true;
  // Of a burst that waits for the gate no pulse is in the schedule yet.
  const bool waits = schedule_->gated && first_of_burst_ == kNotAdded;
  return step_ == Step::playing && (waits ? told_[0] == train(Track::movers).changes().size() : all_told());
}

MonoTime FlashSequencerOutputs::next_due() const noexcept {
  if (step_ == Step::cutting && !broken_) return asked_to_cut_at_ + kAbortAgain;
  if (step_ == Step::start) return link_.answer_due();
  if (loading()) return std::min(link_.answer_due(), start_ - kStartTime);
  return kNoDeadline;  // what is played is told by the answers to beats
}

// ---- cutting ----

bool FlashSequencerOutputs::cut() noexcept {
  const bool asked = link_.abort();
  asked_to_cut_at_ = clock_.now();
  if (step_ == Step::cutting) return asked;
  may_be_on_.fill(asked_to_start_);  // what is still to come may come until the sequencer has cut
  link_.ask_nothing();
  step_ = Step::cutting;
  cut_at_ = looked_at_ = asked_to_cut_at_;
  waited_for_cut_ = {};
  return asked;
}

bool FlashSequencerOutputs::is_cut() const noexcept {
  return known(link_.heard()) && link_.heard() >= cut_at_ && link_.status().phase == Phase::cut &&
         link_.status().outputs == 0;
}

void FlashSequencerOutputs::look() noexcept {
  if (link_.take_reset()) failure_ = kWasReset;
  if (step_ != Step::cutting || is_cut()) return;
  const MonoTime now = clock_.now();
  waited_for_cut_ += std::min(now - looked_at_, kAbortAgain);
  looked_at_ = now;
  if (waited_for_cut_ > kCutTime) broken_ = true;
  if (now < asked_to_cut_at_ + kAbortAgain) return;
  link_.abort();
  asked_to_cut_at_ = now;
}

const char* FlashSequencerOutputs::take_failure() noexcept {
  look();
  return std::exchange(failure_, nullptr);
}

ShortText FlashSequencerOutputs::clock_words() const noexcept {
  const ClockRelation& clocks = link_.clock_relation();
  ShortText words("issued and stamped by the flash sequencer's clock");
  if (!clocks.known()) return words;
  const auto drift_ppb = static_cast<std::int64_t>(clocks.drift() * 1e9);
  const Duration sd = clocks.sd(link_.status().received);
  words.append(", known to ").append(sd.count()).append(" ns, drift ").append(drift_ppb).append(" ppb");
  const ClockAgreement& agreement = link_.agreement();
  if (agreement.count() == 0) return words;
  words.append(", by ").append(static_cast<std::int64_t>(agreement.count()));
  words.append(" edges that the kernel stamped, too, scatter ").append(std::llround(agreement.sd()));
  return words.append(" ns");
}

/// It is, as told, or the instant has come for it to be and it is not yet told.
bool FlashSequencerOutputs::may_be_on(Output output) const noexcept {
  if (!asked_to_start_) return false;
  if (on_[index_of(output)]) return true;
  const Track track = track_of(output);
  const auto changes = train(track).changes().subspan(told_[static_cast<std::size_t>(track)]);
  const bool waits = track == Track::lamps && schedule_->gated && begin_of(track) == kNoTicks;
  if (waits) return !changes.empty() && clock_.now() >= gate_counts_from_;
  const auto next = std::find_if(changes.begin(), changes.end(), [&](const Change& change) {
    return change.on && (track == Track::lamps || schedule_->pulses[change.pulse].output == output);
  });
  if (next == changes.end()) return false;
  const bool gated = track == Track::lamps && schedule_->gated;
  const ClockRelation& clocks = link_.clock_relation();
  const Duration after{next->at * flash_sequencer::kTick_ns};
  const MonoTime due =
      gated && clocks.known() ? clocks.to_time(begin_of(track) + next->at) : start_ - kAhead + after;
  return clock_.now() >= due - kAhead;
}

bool FlashSequencerOutputs::active(Output output) const noexcept {
  if (step_ == Step::cutting) return may_be_on_[index_of(output)];
  return under_way() && may_be_on(output);
}

void FlashSequencerOutputs::end() noexcept {
  step_ = Step::idle;
  schedule_ = nullptr;
  asked_to_start_ = false;
  first_of_burst_ = kNotAdded;
  told_ = {};
  on_ = {};
  may_be_on_ = {};
  asked_to_load_ = {};
  link_.ask_nothing();
}

}  // namespace strobe::firmware
