#include "sim/flash_sequencer/board.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace strobe::sim::sequencer {
namespace {

using namespace flash_sequencer;

constexpr MonoTime kNever = MonoTime::max();
constexpr std::size_t kMaxWaitingEdges = 256;

constexpr std::array kWires{
    std::pair{OutputLine::shutter, RigLine::shutter}, std::pair{OutputLine::trigger, RigLine::trigger},
    std::pair{OutputLine::strobe_a, RigLine::strobe_a}, std::pair{OutputLine::strobe_b, RigLine::strobe_b}};

std::optional<InputLine> input_of(RigLine line) {
  switch (line) {
    case RigLine::key:
      return InputLine::key;
    case RigLine::estop:
      return InputLine::estop;
    case RigLine::sensor_a:
      return InputLine::sensor_a;
    case RigLine::sensor_b:
      return InputLine::sensor_b;
    case RigLine::gate:
      return InputLine::gate;
    case RigLine::xsync:
      return InputLine::xsync;
    default:
      return std::nullopt;
  }
}

bool tells_active_edges_only(InputLine line) {
  return line == InputLine::sensor_a || line == InputLine::sensor_b || line == InputLine::gate;
}

}  // namespace

Board::Board(std::uint64_t seed) : draws_(seed, Purpose::flash_sequencer, 0) {
  const double drift = 1e-6 * kMaxDrift_ppm * (2.0 * draws_.uniform() - 1.0);
  ticks_per_ns_ = (1.0 + drift) / static_cast<double>(kTick_ns);
}

void Board::power_up(MonoTime now) {
  powered_up_ = now_ = now;
  stop(now);
  edges_.clear();
  lost_inputs_ = 0;
  progress_ = {};
}

Ticks Board::ticks(MonoTime instant) const {
  return static_cast<Ticks>(std::floor(static_cast<double>((instant - powered_up_).count()) * ticks_per_ns_));
}

MonoTime Board::instant(Ticks ticks) const {
  return powered_up_ + Duration{std::llround(std::ceil(static_cast<double>(ticks) / ticks_per_ns_))};
}

void Board::advance(MonoTime now) {
  now_ = std::max(now_, now);
  const Ticks until = ticks(now_);
  if (starts_at_ != kNoTicks && until >= starts_at_) {
    progress_.started = starts_at_;
    if (!gated_) progress_.burst_started = starts_at_;
  }
  while (Playing* const next = next_playing(until)) play_edge(*next);
}

Board::Playing* Board::next_playing(Ticks until) {
  Playing* found = nullptr;
  for (Playing& track : playing_) {
    if (track.due == kNoTicks || track.due > until) continue;
    if (found == nullptr || track.due < found->due) found = &track;
  }
  return found;
}

void Board::play_edge(Playing& playing) {
  const auto track = static_cast<std::size_t>(&playing - playing_.data());
  const std::uint8_t own = outputs_of(static_cast<Track>(track));
  std::uint16_t& played = progress_.played[track];
  const auto levels = static_cast<std::uint8_t>(playing.edges[played].levels);
  set_outputs(static_cast<std::uint8_t>((outputs_ & ~own) | (levels & own)), instant(playing.due));
  ++played;
  playing.due = played < playing.edges.size() ? playing.due + playing.edges[played].delay : kNoTicks;
}

MonoTime Board::next_edge() const {
  MonoTime next = kNever;
  for (const Playing& track : playing_)
    if (track.due != kNoTicks) next = std::min(next, instant(track.due));
  return next;
}

void Board::line_changed(RigLine line, int level, MonoTime at) {
  const auto input = input_of(line);
  if (!input) return;
  advance(at);
  const bool active = (level != 0) != (*input == InputLine::estop);
  if (active == ((inputs_ & bit(*input)) != 0)) return;
  inputs_ = static_cast<std::uint8_t>(inputs_ ^ bit(*input));
  if (released_ && forbidden_by() != CutCause::none) {
    cut_by_itself_ = forbidden_by();
    stop(now_);
  }
  if (!active && tells_active_edges_only(*input)) return;
  const Ticks stamp = ticks(at);
  if (*input == InputLine::gate && gated_ && listens_ && progress_.burst_started == kNoTicks) {
    progress_.burst_started = stamp;
    begin(Track::lamps, stamp);
  }
  if (edges_.size() == kMaxWaitingEdges) {
    ++lost_inputs_;
  } else {
    edges_.push_back({0, *input, static_cast<std::uint8_t>(active), stamp});
  }
}

std::vector<PinChange> Board::take_pin_changes() { return std::exchange(pin_changes_, {}); }

void Board::prepare(std::span<Edge> movers, std::span<Edge> lamps) {
  playing_ = {Playing{movers}, Playing{lamps}};
  progress_ = {};
}

void Board::start(Ticks at, bool gated) {
  starts_at_ = at;
  gated_ = gated;
  begin(Track::movers, at);
  if (!gated) begin(Track::lamps, at);
}

void Board::begin(Track track, Ticks at) {
  Playing& playing = playing_[static_cast<std::size_t>(track)];
  if (released_ && !playing.edges.empty()) playing.due = at + playing.edges.front().delay;
}

void Board::cut() { stop(now_); }

bool Board::release() {
  released_ = forbidden_by() == CutCause::none;
  if (released_) cut_by_itself_ = CutCause::none;
  return released_;
}

void Board::stop(MonoTime at) {
  set_outputs(0, at);
  for (Playing& track : playing_) track.due = kNoTicks;
  starts_at_ = kNoTicks;
  released_ = listens_ = gated_ = false;
}

CutCause Board::forbidden_by() const {
  if ((inputs_ & bit(InputLine::estop)) != 0) return CutCause::estop;
  return (inputs_ & bit(InputLine::key)) != 0 ? CutCause::none : CutCause::key;
}

void Board::set_outputs(std::uint8_t levels, MonoTime at) {
  for (const auto& [output, line] : kWires) {
    if (((levels ^ outputs_) & bit(output)) == 0) continue;
    pin_changes_.push_back({at, line, (levels & bit(output)) != 0 ? 1 : 0});
  }
  outputs_ = levels;
}

bool Board::pop_input(InputEdge& edge) {
  if (edges_.empty()) return false;
  edge = edges_.front();
  edges_.pop_front();
  return true;
}

std::uint32_t Board::random() { return static_cast<std::uint32_t>(draws_.uniform() * 0x1p32); }

}  // namespace strobe::sim::sequencer
