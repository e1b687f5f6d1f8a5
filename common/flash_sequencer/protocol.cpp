#include "common/flash_sequencer/protocol.hpp"

#include <bit>
#include <type_traits>

namespace strobe::flash_sequencer {
namespace {

/// Writes a body's fields.
class Writer {
 public:
  explicit Writer(Frame& frame) : frame_(frame) {}

  template <typename Value, typename... Range>
  void operator()(Value value, Range...) {
    if constexpr (std::is_enum_v<Value>) {
      (*this)(static_cast<std::underlying_type_t<Value>>(value));
    } else {
      const auto bits = static_cast<std::make_unsigned_t<Value>>(value);
      for (std::size_t i = 0; i < sizeof bits; ++i) {
        frame_.body[frame_.size++] = static_cast<std::uint8_t>(bits >> (8 * i));
      }
    }
  }
  bool has_edge(std::size_t index, std::uint16_t& count) const { return index < count; }

 private:
  Frame& frame_;
};

/// Reads them; fails once something is missing or not one of its values.
class Reader {
 public:
  explicit Reader(const Frame& frame) : bytes_(frame.bytes()) {}

  template <typename Value>
  void operator()(Value& value) {
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
  void operator()(Value& value, Value last, std::uint8_t first = 0) {
    std::uint8_t raw = 0;
    (*this)(raw);
    good_ = good_ && raw >= first && raw <= static_cast<std::uint8_t>(last);
    if (good_) value = static_cast<Value>(raw);
  }
  bool has_edge(std::size_t index, std::uint16_t& count) const {
    if (!good_ || bytes_.empty() || index == Load::kMaxEdges) return false;
    ++count;
    return true;
  }
  bool whole() const { return good_ && bytes_.empty(); }

 private:
  std::span<const std::uint8_t> bytes_;
  bool good_ = true;
};

static_assert(3 + Load::kMaxEdges * 8 <= kMaxBody);

constexpr auto kLastRequest = Request::reset;
constexpr auto kFirstRequest = static_cast<std::uint8_t>(Request::hello);

// The fields of each body in their order, with the range of those that have one; to a Writer or a Reader.

template <typename Body>
void fields(Body& body, Limits& limits) {
  for (std::uint32_t& max_on_us : limits.max_on_us) body(max_on_us);
}

template <typename Body>
void fields(Body& body, Load& load) {
  body(load.track, Track::lamps);
  body(load.first);
  for (std::size_t i = 0; body.has_edge(i, load.count); ++i) {
    body(load.edges[i].delay);
    body(load.edges[i].levels);
  }
}

template <typename Body>
void fields(Body& body, Arm& arm) {
  for (std::uint16_t& edges : arm.edges) body(edges);
  body(arm.crc);
  body(arm.gated, std::uint8_t{1});
}

template <typename Body>
void fields(Body& body, Start& start) {
  body(start.challenge);
  body(start.at);
  body(start.gate_from);
  body(start.gate_until);
}

template <typename Body>
void fields(Body& body, Identity& identity) {
  body(identity.version);
  body(identity.boot);
  body(identity.reset_by_watchdog);
  body(identity.max_edges);
}

template <typename Body>
void fields(Body& body, Status& status) {
  body(status.answers, kLastRequest, kFirstRequest);
  body(status.refusal, Refusal::too_late);
  body(status.phase, Phase::cut);
  body(status.cut, CutCause::overrun);
  body(status.inputs);
  body(status.outputs);
  body(status.challenge);
  body(status.received);
  body(status.started);
  body(status.burst_started);
  for (std::uint16_t& played : status.played) body(played);
  body(status.lost_inputs);
  body(status.next_input);
}

template <typename Body>
void fields(Body& body, InputEdge& edge) {
  body(edge.number);
  body(edge.line, InputLine::xsync);
  body(edge.active, std::uint8_t{1});
  body(edge.time);
}

/// HELLO's.
template <typename Body>
void fields(Body& body, std::uint8_t& version) {
  body(version);
}

template <typename Kind, typename Value>
Frame written(Kind kind, Value value) {
  Frame frame;
  frame.kind = static_cast<std::uint8_t>(kind);
  Writer writer(frame);
  fields(writer, value);
  return frame;
}

template <typename Value, typename Kind>
std::optional<Value> read(const Frame& frame, Kind kind) {
  if (frame.kind != static_cast<std::uint8_t>(kind)) return std::nullopt;
  Value value{};
  Reader reader(frame);
  fields(reader, value);
  return reader.whole() ? std::optional(value) : std::nullopt;
}

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
  if (request == Request::hello) return written(request, kVersion);
  Frame frame;
  frame.kind = static_cast<std::uint8_t>(request);
  return frame;
}
Frame to_frame(const Limits& limits) { return written(Request::limits, limits); }
Frame to_frame(const Load& load) { return written(Request::load, load); }
Frame to_frame(const Arm& arm) { return written(Request::arm, arm); }
Frame to_frame(const Start& start) { return written(Request::start, start); }
Frame to_frame(const Identity& identity) { return written(Reply::identity, identity); }
Frame to_frame(const Status& status) { return written(Reply::status, status); }
Frame to_frame(const InputEdge& edge) { return written(Reply::input, edge); }

std::optional<std::uint8_t> read_hello(const Frame& frame) {
  return read<std::uint8_t>(frame, Request::hello);
}
std::optional<Limits> read_limits(const Frame& frame) { return read<Limits>(frame, Request::limits); }
std::optional<Load> read_load(const Frame& frame) { return read<Load>(frame, Request::load); }
std::optional<Arm> read_arm(const Frame& frame) { return read<Arm>(frame, Request::arm); }
std::optional<Start> read_start(const Frame& frame) { return read<Start>(frame, Request::start); }
std::optional<Identity> read_identity(const Frame& frame) { return read<Identity>(frame, Reply::identity); }
std::optional<Status> read_status(const Frame& frame) { return read<Status>(frame, Reply::status); }
std::optional<InputEdge> read_input(const Frame& frame) { return read<InputEdge>(frame, Reply::input); }

}  // namespace strobe::flash_sequencer
