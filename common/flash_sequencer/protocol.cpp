#include "common/flash_sequencer/protocol.hpp"

#include <bit>
#include <type_traits>

namespace strobe::flash_sequencer {
namespace {

template <typename Kind>
Frame frame_of(Kind kind) {
  Frame frame;
  frame.kind = static_cast<std::uint8_t>(kind);
  return frame;
}

template <typename Value>
void put(Frame& frame, Value value) {
  if constexpr (std::is_enum_v<Value>) {
    put(frame, static_cast<std::underlying_type_t<Value>>(value));
  } else {
    const auto bits = static_cast<std::make_unsigned_t<Value>>(value);
    for (std::size_t i = 0; i < sizeof bits; ++i) {
      frame.body[frame.size++] = static_cast<std::uint8_t>(bits >> (8 * i));
    }
  }
}

/// Reads a body from its beginning; fails once something is missing or not one of its values.
class Body {
 public:
  template <typename Kind>
  Body(const Frame& frame, Kind kind)
      : bytes_(frame.bytes()), good_(frame.kind == static_cast<std::uint8_t>(kind)) {}

  template <typename Value>
  void get(Value& value) {
    good_ = good_ && bytes_.size() >= sizeof(Value);
    if (!good_) return;
    std::make_unsigned_t<Value> bits = 0;
    for (std::size_t i = 0; i < sizeof(Value); ++i) {
      bits =
          static_cast<std::make_unsigned_t<Value>>(bits | static_cast<std::uint64_t>(bytes_[i]) << (8 * i));
    }
    bytes_ = bytes_.subspan(sizeof(Value));
    value = static_cast<Value>(bits);
  }
  template <typename Value>
  void get(Value& value, Value last, std::uint8_t first = 0) {
    std::uint8_t raw = 0;
    get(raw);
    good_ = good_ && raw >= first && raw <= static_cast<std::uint8_t>(last);
    if (good_) value = static_cast<Value>(raw);
  }
  std::size_t left() const { return good_ ? bytes_.size() : 0; }

  template <typename Value>
  std::optional<Value> whole(const Value& value) const {
    return good_ && bytes_.empty() ? std::optional(value) : std::nullopt;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  bool good_;
};

static_assert(3 + Load::kMaxEdges * 8 <= kMaxBody);

constexpr auto kLastRequest = Request::reset;
constexpr auto kFirstRequest = static_cast<std::uint8_t>(Request::hello);

}  // namespace

std::uint32_t train_crc(std::span<const Edge> movers, std::span<const Edge> lamps) {
  // As they lie in memory: a full train in milliseconds, on a small processor that must hear beats in
  // between.
  static_assert(std::endian::native == std::endian::little && sizeof(Edge) == 8);
  std::uint32_t crc = 0;
  for (const auto track : {movers, lamps}) {
    crc = crc32(std::span(reinterpret_cast<const std::uint8_t*>(track.data()), track.size_bytes()), crc);
  }
  return crc;
}

Frame to_frame(Request request) {
  Frame frame = frame_of(request);
  if (request == Request::hello) put(frame, kVersion);
  return frame;
}

Frame to_frame(const Limits& limits) {
  Frame frame = frame_of(Request::limits);
  for (const std::uint32_t max_on_us : limits.max_on_us) put(frame, max_on_us);
  return frame;
}

Frame to_frame(const Load& load) {
  Frame frame = frame_of(Request::load);
  put(frame, load.track);
  put(frame, load.first);
  for (std::size_t i = 0; i < load.count; ++i) {
    put(frame, load.edges[i].delay);
    put(frame, load.edges[i].levels);
  }
  return frame;
}

Frame to_frame(const Arm& arm) {
  Frame frame = frame_of(Request::arm);
  for (const std::uint16_t edges : arm.edges) put(frame, edges);
  put(frame, arm.crc);
  put(frame, arm.gated);
  return frame;
}

Frame to_frame(const Start& start) {
  Frame frame = frame_of(Request::start);
  put(frame, start.challenge);
  put(frame, start.at);
  put(frame, start.gate_from);
  put(frame, start.gate_until);
  return frame;
}

Frame to_frame(const Identity& identity) {
  Frame frame = frame_of(Reply::identity);
  put(frame, identity.version);
  put(frame, identity.boot);
  put(frame, identity.reset_by_watchdog);
  put(frame, identity.max_edges);
  return frame;
}

Frame to_frame(const Status& status) {
  Frame frame = frame_of(Reply::status);
  put(frame, status.answers);
  put(frame, status.refusal);
  put(frame, status.phase);
  put(frame, status.cut);
  put(frame, status.inputs);
  put(frame, status.outputs);
  put(frame, status.challenge);
  put(frame, status.received);
  put(frame, status.started);
  put(frame, status.burst_started);
  for (const std::uint16_t played : status.played) put(frame, played);
  put(frame, status.lost_inputs);
  put(frame, status.next_input);
  return frame;
}

Frame to_frame(const InputEdge& edge) {
  Frame frame = frame_of(Reply::input);
  put(frame, edge.number);
  put(frame, edge.line);
  put(frame, edge.active);
  put(frame, edge.time);
  return frame;
}

std::optional<std::uint8_t> read_hello(const Frame& frame) {
  Body body(frame, Request::hello);
  std::uint8_t version = 0;
  body.get(version);
  return body.whole(version);
}

std::optional<Limits> read_limits(const Frame& frame) {
  Body body(frame, Request::limits);
  Limits limits;
  for (std::uint32_t& max_on_us : limits.max_on_us) body.get(max_on_us);
  return body.whole(limits);
}

std::optional<Load> read_load(const Frame& frame) {
  Body body(frame, Request::load);
  Load load;
  body.get(load.track, Track::lamps);
  body.get(load.first);
  while (body.left() > 0 && load.count < Load::kMaxEdges) {
    Edge& edge = load.edges[load.count++];
    body.get(edge.delay);
    body.get(edge.levels);
  }
  return body.whole(load);
}

std::optional<Arm> read_arm(const Frame& frame) {
  Body body(frame, Request::arm);
  Arm arm;
  for (std::uint16_t& edges : arm.edges) body.get(edges);
  body.get(arm.crc);
  body.get(arm.gated, std::uint8_t{1});
  return body.whole(arm);
}

std::optional<Start> read_start(const Frame& frame) {
  Body body(frame, Request::start);
  Start start;
  body.get(start.challenge);
  body.get(start.at);
  body.get(start.gate_from);
  body.get(start.gate_until);
  return body.whole(start);
}

std::optional<Identity> read_identity(const Frame& frame) {
  Body body(frame, Reply::identity);
  Identity identity;
  body.get(identity.version);
  body.get(identity.boot);
  body.get(identity.reset_by_watchdog);
  body.get(identity.max_edges);
  return body.whole(identity);
}

std::optional<Status> read_status(const Frame& frame) {
  Body body(frame, Reply::status);
  Status status;
  body.get(status.answers, kLastRequest, kFirstRequest);
  body.get(status.refusal, Refusal::too_late);
  body.get(status.phase, Phase::cut);
  body.get(status.cut, CutCause::overrun);
  body.get(status.inputs);
  body.get(status.outputs);
  body.get(status.challenge);
  body.get(status.received);
  body.get(status.started);
  body.get(status.burst_started);
  for (std::uint16_t& played : status.played) body.get(played);
  body.get(status.lost_inputs);
  body.get(status.next_input);
  return body.whole(status);
}

std::optional<InputEdge> read_input(const Frame& frame) {
  Body body(frame, Reply::input);
  InputEdge edge;
  body.get(edge.number);
  body.get(edge.line, InputLine::xsync);
  body.get(edge.active, std::uint8_t{1});
  body.get(edge.time);
  return body.whole(edge);
}

}  // namespace strobe::flash_sequencer
