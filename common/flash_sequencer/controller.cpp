#include "common/flash_sequencer/controller.hpp"

#include <algorithm>

namespace strobe::flash_sequencer {
namespace {

/// A train that is not over so long after its length is cut.
constexpr Ticks kOverrun = ticks_of_us(2'000);

bool is_request(std::uint8_t kind) {
  return kind >= static_cast<std::uint8_t>(Request::hello) &&
         kind <= static_cast<std::uint8_t>(Request::reset);
}

bool same(const Frame& one, const Frame& other) {
  const auto bytes = one.bytes();
  const auto others = other.bytes();
  return one.kind == other.kind && one.number == other.number &&
         std::equal(bytes.begin(), bytes.end(), others.begin(), others.end());
}

Refusal forbidden_by(std::uint8_t inputs) {
  if ((inputs & bit(InputLine::estop)) != 0) return Refusal::estop_pressed;
  return (inputs & bit(InputLine::key)) != 0 ? Refusal::none : Refusal::key_off;
}

/// Of the edges of one track. On a small processor a full train must take less than a beat.
Refusal check_edges(std::span<const Edge> edges, Track track, const Limits& limits) {
  std::array<Ticks, kOutputCount> longest{};
  for (std::size_t line = 0; line < kOutputCount; ++line) longest[line] = ticks_of_us(limits.max_on_us[line]);
  std::array<Ticks, kOutputCount> on_for{};
  std::uint32_t levels = 0;
  for (const Edge& edge : edges) {
    if (edge.delay < kMinDelay) return Refusal::delay_too_short;
    if ((edge.levels & ~std::uint32_t{outputs_of(track)}) != 0) return Refusal::foreign_line;
    if (levels == 0) {
      on_for = {};
    } else {
      for (std::size_t line = 0; line < kOutputCount; ++line) {
        if (((outputs_of(track) >> line) & 1U) == 0) continue;
        const bool was_on = ((levels >> line) & 1U) != 0;
        on_for[line] = was_on ? on_for[line] + edge.delay : 0;
        if (on_for[line] > longest[line]) return Refusal::on_too_long;
      }
    }
    levels = edge.levels;
  }
  return levels == 0 ? Refusal::none : Refusal::ends_active;
}

}  // namespace

Controller::Controller(Hardware& hardware, std::uint64_t boot, bool reset_by_watchdog) : hardware_(hardware) {
  identity_.boot = boot;
  identity_.reset_by_watchdog = reset_by_watchdog ? 1 : 0;
  hardware_.cut();
}

bool Controller::answer(const Frame& request, Ticks received, Frame& reply) {
  if (!is_request(request.kind)) return false;
  const auto kind = static_cast<Request>(request.kind);
  // What is harmless to repeat is never answered from memory.
  const bool repeatable = kind == Request::beat || kind == Request::abort;
  if (!repeatable && last_request_ && same(*last_request_, request)) {
    reply = last_reply_;
    return true;
  }
  if (kind == Request::beat) {
    watch_heartbeat(received);
    last_beat_ = received;
  }
  if (kind == Request::hello && read_hello(request)) {
    reply = to_frame(identity_);
  } else {
    const Refusal refusal = carry_out(request);
    reply = to_frame(status(kind, refusal, received));
  }
  reply.number = request.number;
  if (kind == Request::beat) return true;
  last_request_ = request;
  last_reply_ = reply;
  return true;
}

Refusal Controller::carry_out(const Frame& request) {
  switch (static_cast<Request>(request.kind)) {
    case Request::hello:
      return Refusal::malformed;
    case Request::limits:
      return limits(request);
    case Request::load:
      return load(request);
    case Request::arm:
      return arm(request);
    case Request::start:
      return start(request);
    case Request::beat:
      return Refusal::none;
    case Request::abort:
      cut(CutCause::abort);
      return Refusal::none;
    case Request::reset:
      return reset();
  }
  return Refusal::malformed;
}

Refusal Controller::limits(const Frame& request) {
  const auto asked = read_limits(request);
  if (!asked) return Refusal::malformed;
  if (phase_ != Phase::idle && phase_ != Phase::cut) return Refusal::wrong_phase;
  limits_ = *asked;
  return Refusal::none;
}

Refusal Controller::load(const Frame& request) {
  const auto load = read_load(request);
  if (!load) return Refusal::malformed;
  if (phase_ != Phase::idle) return Refusal::wrong_phase;
  Loaded& track = tracks_[static_cast<std::size_t>(load->track)];
  if (load->first == 0) track.clear();
  if (load->first != track.count || track.count + load->count > kMaxEdges) return Refusal::bad_index;
  for (std::size_t i = 0; i < load->count; ++i) {
    track.edges[track.count++] = load->edges[i];
    track.length += load->edges[i].delay;
  }
  return Refusal::none;
}

Refusal Controller::arm(const Frame& request) {
  const auto arm = read_arm(request);
  if (!arm) return Refusal::malformed;
  if (phase_ != Phase::idle) return Refusal::wrong_phase;
  for (std::size_t track = 0; track < kTrackCount; ++track) {
    if (arm->edges[track] != tracks_[track].count) return Refusal::train_differs;
  }
  if (arm->crc != train_crc(edges(Track::movers), edges(Track::lamps))) return Refusal::train_differs;
  for (const Track track : {Track::movers, Track::lamps}) {
    if (const Refusal why = check_edges(edges(track), track, limits_); why != Refusal::none) return why;
  }
  if (const Refusal why = forbidden(); why != Refusal::none) return why;
  hardware_.prepare(edges(Track::movers), edges(Track::lamps));
  challenge_ = std::max(hardware_.random(), std::uint32_t{1});
  gated_ = arm->gated != 0;
  armed_at_ = hardware_.now();
  progress_ = {};
  phase_ = Phase::armed;
  return Refusal::none;
}

Refusal Controller::start(const Frame& request) {
  const auto start = read_start(request);
  if (!start || start->gate_from < 0 || start->gate_until < start->gate_from ||
      start->gate_until > kMaxAhead) {
    return Refusal::malformed;
  }
  if (phase_ != Phase::armed) return Refusal::wrong_phase;
  if (start->challenge != challenge_) return Refusal::wrong_challenge;
  if (const Refusal why = forbidden(); why != Refusal::none) return why;
  const Ticks now = hardware_.now();
  if (start->at < now + kStartLead) return Refusal::too_late;
  if (start->at > now + kMaxAhead) return Refusal::malformed;
  start_ = *start;
  challenge_ = 0;
  phase_ = Phase::playing;
  hardware_.start(start_.at, gated_);
  return Refusal::none;
}

Refusal Controller::reset() {
  if (phase_ == Phase::idle) return Refusal::none;
  if (phase_ != Phase::cut) return Refusal::wrong_phase;
  if (const Refusal why = forbidden_by(hardware_.inputs()); why != Refusal::none) return why;
  if (!hardware_.release()) return Refusal::estop_pressed;  // and just released again
  phase_ = Phase::idle;
  cut_ = CutCause::none;
  return Refusal::none;
}

Refusal Controller::forbidden() {
  const Refusal why = forbidden_by(hardware_.inputs());
  if (why != Refusal::none) return why;
  return beats_come(hardware_.now()) ? Refusal::none : Refusal::no_heartbeat;
}

bool Controller::beats_come(Ticks now) const {
  return last_beat_ != kNoTicks && now - last_beat_ <= kHeartbeatTimeout;
}

void Controller::watch_heartbeat(Ticks now) {
  const bool needed = phase_ == Phase::armed || phase_ == Phase::playing;
  if (needed && !beats_come(now)) cut(CutCause::heartbeat);
}

void Controller::turn() {
  if (phase_ == Phase::cut) return;
  if (const CutCause cause = hardware_.cut_by_itself(); cause != CutCause::none) return cut(cause);
  watch_heartbeat(hardware_.now());
  if (phase_ == Phase::armed && hardware_.now() > armed_at_ + kArmedFor) disarm();
  if (phase_ == Phase::playing) watch_train();
}

void Controller::watch_train() {
  const Ticks now = hardware_.now();
  const Ticks gate_until = start_.at + start_.gate_until;
  const bool listens = gated_ && now >= start_.at + start_.gate_from && now < gate_until;
  if (listens != listening_) {
    listening_ = listens;
    hardware_.listen_to_gate(listens);
  }
  progress_ = hardware_.progress();
  if (progress_.underrun) return cut(CutCause::underrun);

  const Ticks lamps = tracks_[static_cast<std::size_t>(Track::lamps)].length;
  Ticks end = start_.at + tracks_[static_cast<std::size_t>(Track::movers)].length;
  bool lamps_over = played_all(Track::lamps);
  if (!gated_) {
    end = std::max(end, start_.at + lamps);
  } else if (progress_.burst_started != kNoTicks) {
    end = std::max(end, progress_.burst_started + lamps);
  } else {
    end = std::max(end, gate_until);
    lamps_over = now >= gate_until;
  }
  if (played_all(Track::movers) && lamps_over) {
    end_train();
  } else if (now > end + kOverrun) {
    cut(CutCause::overrun);
  }
}

bool Controller::played_all(Track track) const {
  const auto index = static_cast<std::size_t>(track);
  return progress_.played[index] >= tracks_[index].count;
}

std::span<Edge> Controller::edges(Track track) {
  Loaded& loaded = tracks_[static_cast<std::size_t>(track)];
  return std::span(loaded.edges).first(loaded.count);
}

void Controller::end_train() {
  phase_ = Phase::idle;
  challenge_ = 0;
  listening_ = false;
  for (Loaded& track : tracks_) track.clear();
}

/// Without a cut and a release, which would forget what key or e-stop did meanwhile.
void Controller::disarm() {
  hardware_.prepare({}, {});
  end_train();
}

void Controller::cut(CutCause cause) {
  hardware_.cut();
  if (phase_ == Phase::playing) progress_ = hardware_.progress();
  if (phase_ != Phase::cut || cut_ == CutCause::none) cut_ = cause;
  end_train();
  phase_ = Phase::cut;
}

Status Controller::status(Request answers, Refusal refusal, Ticks received) {
  if (phase_ == Phase::playing) progress_ = hardware_.progress();
  Status status;
  status.answers = answers;
  status.refusal = refusal;
  status.phase = phase_;
  status.cut = cut_;
  status.inputs = hardware_.inputs();
  status.outputs = hardware_.outputs();
  status.challenge = challenge_;
  status.received = received;
  status.started = progress_.started;
  status.burst_started = progress_.burst_started;
  status.played = progress_.played;
  status.lost_inputs = hardware_.lost_inputs();
  status.next_input = next_input_;
  return status;
}

bool Controller::next_input(Frame& report) {
  InputEdge edge;
  if (!hardware_.pop_input(edge)) return false;
  edge.number = next_input_++;
  report = to_frame(edge);
  return true;
}

}  // namespace strobe::flash_sequencer
