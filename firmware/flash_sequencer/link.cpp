#include "firmware/flash_sequencer/link.hpp"

#include <algorithm>
#include <cstdlib>

namespace strobe::firmware {

using flash_sequencer::CutCause;
using flash_sequencer::Frame;
using flash_sequencer::Identity;
using flash_sequencer::InputEdge;
using flash_sequencer::InputLine;
using flash_sequencer::Phase;
using flash_sequencer::Request;
using flash_sequencer::Status;
using flash_sequencer::Ticks;

namespace {

/// Years within which nothing overflows; what is beyond is no stamp of a sequencer's.
constexpr flash_sequencer::Ticks kLongestOn = flash_sequencer::ticks_of_us(1'000'000) * 86'400 * 365 * 10;

bool plausible(flash_sequencer::Ticks ticks) {
  return ticks == flash_sequencer::kNoTicks || (ticks >= 0 && ticks <= kLongestOn);
}

}  // namespace

bool send_abort(SerialLine& line) noexcept {
  return send(line, flash_sequencer::to_frame(Request::abort));  // number 0 is nobody else's
}

Result<void> FlashSequencerLink::turn_for(Duration duration) {
  for (const MonoTime end = clock_.now() + duration; clock_.now() < end;) {
    if (!take()) return fail("the flash sequencer's line is gone");
    wait(end);
  }
  return {};
}

Result<void> FlashSequencerLink::make_inactive(Duration patience) {
  heard_ = kNoTime;
  for (const MonoTime end = clock_.now() + patience; clock_.now() < end;) {
    abort();
    if (const auto turned = turn_for(kAnswerTime); !turned) return turned;
    const bool is_cut = status_.phase == flash_sequencer::Phase::cut && status_.outputs == 0;
    if (known(heard_) && is_cut) return {};
  }
  return fail(known(heard_) ? "the flash sequencer does not cut its outputs" : "no flash sequencer answers");
}

Result<void> FlashSequencerLink::connect(Duration patience) {
  const MonoTime end = clock_.now() + patience;
  if (const auto cut = make_inactive(patience); !cut) return cut;
  ask(flash_sequencer::to_frame(Request::hello));
  constexpr int kBeats = 25;  // to relate the clocks by
  for (int beats = 0; beats < kBeats || !identity_ || !relation_.known(); ++beats) {
    if (clock_.now() >= end) return fail("the flash sequencer hardly answers");
    heartbeat_.beat();
    if (const auto turned = turn_for(Heartbeat::kEvery); !turned) return turned;
    ask_again();
  }
  was_reset_ = false;
  if (identity_->version == flash_sequencer::kVersion) return {};
  return fail("the flash sequencer speaks version " + std::to_string(identity_->version) +
              " of the protocol, strobed " + std::to_string(flash_sequencer::kVersion));
}

bool FlashSequencerLink::take() noexcept {
  std::array<std::uint8_t, 1024> bytes;
  for (;;) {
    const MonoTime looked = clock_.now();
    const auto count = line_.read(bytes);
    if (!count) return false;
    looked_ = looked;
    const MonoTime heard = *count > 0 ? clock_.now() : looked;
    for (std::size_t i = 0; i < *count; ++i) {
      const Frame* frame = decoder_.take(bytes[i]);
      if (frame != nullptr) hear(*frame, heard);
    }
    if (*count < bytes.size()) return true;
  }
}

void FlashSequencerLink::ask(const Frame& request) noexcept {
  const std::uint8_t number = request_.number;
  request_ = request;
  request_.number = number + 1 >= Heartbeat::kFirstNumber ? 1 : static_cast<std::uint8_t>(number + 1);
  waiting_ = true;
  answer_.reset();
  asked_at_ = clock_.now();
  send(line_, request_);
}

void FlashSequencerLink::hold_clock_relation(MonoTime until) noexcept {
  if (running_.count() >= ClockAgreement::kMinCount) agreement_ = running_;
  running_ = {};
  held_ = base_ = relation_;
  if (agreement_.count() > 0) held_.shift(agreement_.mean(), agreement_.mean_sd());
  held_until_ = until;
}

void FlashSequencerLink::witness(Ticks ticks, MonoTime kernel_stamp) noexcept {
  if (looked_ < held_until_) running_.add(kernel_stamp - base_.to_time(ticks));
}

std::optional<Status> FlashSequencerLink::take_answer() noexcept {
  return std::exchange(answer_, std::nullopt);
}

void FlashSequencerLink::ask_again() noexcept {
  if (!waiting_ || clock_.now() < answer_due()) return;
  asked_at_ = clock_.now();
  send(line_, request_);
}

void FlashSequencerLink::answered(std::uint8_t number, const Status& status) noexcept {
  if (!waiting_ || number != request_.number) return;
  waiting_ = false;
  answer_ = status;
}

void FlashSequencerLink::hear(const Frame& frame, MonoTime heard) noexcept {
  if (const auto status = read_status(frame)) {
    const bool known_time = status->received != flash_sequencer::kNoTicks;
    const bool stamps =
        plausible(status->received) && plausible(status->started) && plausible(status->burst_started);
    if (known_time && stamps) hear(*status, frame, heard);
  }
  if (const auto edge = read_input(frame); edge && edge->time >= 0 && plausible(edge->time)) hear(*edge);
  if (const auto identity = read_identity(frame)) hear(*identity, frame.number);
}

void FlashSequencerLink::hear(const Status& status, const Frame& frame, MonoTime heard) noexcept {
  // Answers to these two are never from the sequencer's memory.
  const bool fresh = status.answers == Request::beat || status.answers == Request::abort;
  if (known(heard_) && status.received < status_.received) {
    if (!fresh) return answered(frame.number, status);
    started_anew();
  }
  const bool was_cut = known(heard_) && status_.phase == Phase::cut;
  status_ = status;
  heard_ = looked_ = heard;
  inputs_ = status.inputs;
  if (!was_cut) note_cut();
  note_gate();
  lost_there_ = status.lost_inputs;
  expect_edge(status.next_input);
  if (status.answers != Request::beat) return answered(frame.number, status);
  if (const auto beat = heartbeat_.departure(frame.number)) {
    const SerialLine::Pace pace = line_.pace();
    const MonoTime answered_by = heard - heard_size(frame) * pace.byte - pace.reply;
    relation_.observe(beat->not_before, status.received, std::min(beat->not_after, answered_by));
  }
}

/// Key or e-stop may be back already, and the reports of it lost: whoever arms the rig is to know of it.
void FlashSequencerLink::note_cut() noexcept {
  const bool by_key = status_.cut == CutCause::key;
  if (status_.phase != Phase::cut || (!by_key && status_.cut != CutCause::estop)) return;
  const InputLine line = by_key ? InputLine::key : InputLine::estop;
  const bool active = (status_.inputs & flash_sequencer::bit(line)) != 0;
  keep({0, line, static_cast<std::uint8_t>(by_key ? 0 : 1), status_.received});
  keep({0, line, static_cast<std::uint8_t>(active ? 1 : 0), status_.received});
}

/// The gate's edge that a burst began with, should the report of it have been lost.
void FlashSequencerLink::note_gate() noexcept {
  const Ticks gate = status_.burst_started;
  if (gate != flash_sequencer::kNoTicks && std::abs(gate - last_gate_) > kSameGate)
    keep({0, InputLine::gate, 1, gate});
}

/// Edges come in the order of their numbers: those between this one and the last were lost.
void FlashSequencerLink::expect_edge(std::uint16_t number) noexcept {
  if (next_edge_) lost_edges_ += static_cast<std::uint16_t>(number - *next_edge_);
  next_edge_ = number;
}

void FlashSequencerLink::hear(const InputEdge& edge) noexcept {
  expect_edge(edge.number);
  next_edge_ = static_cast<std::uint16_t>(edge.number + 1);
  const std::uint8_t line = flash_sequencer::bit(edge.line);
  inputs_ = static_cast<std::uint8_t>(edge.active != 0 ? inputs_ | line : inputs_ & ~line);
  const bool told = edge.line == InputLine::gate && std::abs(edge.time - last_gate_) <= kSameGate;
  if (!told) keep(edge);
}

void FlashSequencerLink::keep(const InputEdge& edge) noexcept {
  if (edge.line == InputLine::gate && edge.active != 0) last_gate_ = edge.time;
  if (edge_count_ == kEdges) {
    ++lost_edges_;
    return;
  }
  edges_[(first_edge_ + edge_count_++) % kEdges] = edge;
}

bool FlashSequencerLink::take_edge(InputEdge& edge) noexcept {
  if (edge_count_ == 0) return false;
  edge = edges_[first_edge_];
  first_edge_ = (first_edge_ + 1) % kEdges;
  --edge_count_;
  return true;
}

void FlashSequencerLink::hear(const Identity& identity, std::uint8_t number) noexcept {
  if (identity_ && identity_->boot != identity.boot) started_anew();
  identity_ = identity;
  answered(number, Status{Request::hello});
}

void FlashSequencerLink::started_anew() noexcept {
  was_reset_ = true;
  relation_.forget();
  held_until_ = kNoTime;
  last_gate_ = kNever;
  agreement_ = running_ = {};
  next_edge_.reset();
  lost_edges_ += lost_there_;
  lost_there_ = 0;
  status_.received = flash_sequencer::kNoTicks;
  identity_.reset();
}

}  // namespace strobe::firmware
