// What strobed and a flash sequencer say to each other. The sequencer is a microcontroller that plays a
// shot's output edges by its own clock and stamps the inputs' edges with it (firmware/sequencer/).
//
// A frame on the wire is COBS (Cheshire and Baker, "Consistent overhead byte stuffing", 1999), ended by a
// zero byte, of: kind (1 byte), number (1 byte), body, CRC-32 of all before (IEEE 802.3, least significant
// byte first). Numbers are little-endian. Every request is answered by one reply with the request's number;
// input edges come unasked. What is damaged gets no answer: who asked asks again with the same number, and a
// request that was heard before is answered, not carried out again.
//
// Freestanding but for the standard library's headers: no allocation, no exceptions. Plain values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace strobe::flash_sequencer {

inline constexpr std::uint8_t kVersion = 2;

/// The sequencer's clock since it was started, in steps of kTick_ns.
using Ticks = std::int64_t;
inline constexpr std::int64_t kTick_ns = 8;
inline constexpr Ticks kNoTicks = std::numeric_limits<Ticks>::min();
constexpr Ticks ticks_of_us(std::int64_t us) { return us * 1000 / kTick_ns; }

/// Without a beat for so long, whatever is armed or playing is cut.
inline constexpr Ticks kHeartbeatTimeout = ticks_of_us(15'000);

/// No reply begins earlier than so long after its request's last byte, and one to an idle sequencer's beat
/// not much later: by it the clocks are related.
inline constexpr Ticks kReplyAfter = ticks_of_us(100);

/// Of Edge::levels and Levels::outputs: 1 << line.
enum class OutputLine : std::uint8_t { shutter, trigger, strobe_a, strobe_b, auxiliary_a, auxiliary_b };
inline constexpr std::size_t kOutputCount = 6;
/// Of Levels::inputs: 1 << line; logical: key on, e-stop pressed, others active.
enum class InputLine : std::uint8_t { key, estop, sensor_a, sensor_b, gate, xsync };
inline constexpr std::size_t kInputCount = 6;
template <typename Line>
constexpr std::uint8_t bit(Line line) {
  return static_cast<std::uint8_t>(1U << static_cast<unsigned>(line));
}

/// Outputs in two groups, each with edges of its own: the burst of a gated shot begins when the gate says so,
/// while shutter and trigger keep their instants.
enum class Track : std::uint8_t { movers, lamps };
inline constexpr std::size_t kTrackCount = 2;
constexpr std::uint8_t outputs_of(Track track) { return track == Track::movers ? 0b000011 : 0b111100; }
inline constexpr std::size_t kMaxEdges = 2048;  ///< of a track

/// From the edge before of the same track, the first one from the start (or from the gate's edge), to this
/// one, which sets all outputs of the track.
struct Edge {
  std::uint32_t delay = 0;   ///< ticks, at least kMinDelay
  std::uint32_t levels = 0;  ///< bits of OutputLine
};
inline constexpr std::uint32_t kMinDelay = 16;

/// What a host may ask for.
enum class Request : std::uint8_t {
  hello = 1,  ///< version u8 -> Identity
  limits,     ///< longest on-time of each output, 6 x u32 [us]; 0: never on
  load,       ///< track u8, index of the first u16, then (delay u32, levels u8)...; index 0 empties the track
  arm,        ///< edges of each track 2 x u16, CRC-32 of all u32 (train_crc), gated u8
  start,      ///< challenge u32 (of the reply to arm), at i64 [ticks], gate window i64, i64 [ticks from the
              ///< start]
  beat,       ///< nothing
  abort,      ///< nothing: cut now
  reset,      ///< nothing: ends a cut, with the key on and the e-stop released
};
enum class Reply : std::uint8_t { identity = 0x81, status = 0x82, input = 0x83 };

enum class Phase : std::uint8_t {
  idle,     ///< nothing is armed, no output active
  armed,    ///< a train is loaded and has a challenge; for kArmedFor
  playing,  ///< from START, before the instant of the start as well
  cut,      ///< outputs are inactive and stay so until a reset
};
inline constexpr Ticks kArmedFor = ticks_of_us(1'000'000);

/// Why the outputs were cut; the first of several.
enum class CutCause : std::uint8_t {
  none,
  key,        ///< off
  estop,      ///< pressed
  heartbeat,  ///< none for kHeartbeatTimeout
  abort,      ///< asked for
  underrun,   ///< an edge could not be fetched in time
  overrun,    ///< the train was not over when it should have been
};

/// Why a request was not carried out.
enum class Refusal : std::uint8_t {
  none,
  malformed,        ///< its body
  wrong_phase,      ///< not in this one
  bad_index,        ///< an edge's number is neither 0 nor the next, or there are too many
  foreign_line,     ///< an edge sets outputs of the other track
  delay_too_short,  ///< less than kMinDelay
  train_differs,    ///< from the counts and the CRC of ARM
  ends_active,      ///< the last edge of a track leaves an output active
  on_too_long,      ///< an output longer than its limit
  key_off,
  estop_pressed,
  no_heartbeat,
  wrong_challenge,
  too_late,  ///< START less than kStartLead before its instant
};
inline constexpr Ticks kStartLead = ticks_of_us(500);
/// START is not further ahead, and its gate's window no longer, or it is malformed.
inline constexpr Ticks kMaxAhead = ticks_of_us(30'000'000);

struct Identity {
  std::uint8_t version = kVersion;
  std::uint64_t boot = 0;  ///< drawn at each start
  std::uint8_t reset_by_watchdog = 0;
  std::uint16_t max_edges = kMaxEdges;
};

/// The reply to all requests but HELLO.
struct Status {
  Request answers = Request::beat;
  Refusal refusal = Refusal::none;
  Phase phase = Phase::idle;
  CutCause cut = CutCause::none;
  std::uint8_t inputs = 0;
  std::uint8_t outputs = 0;
  std::uint32_t challenge = 0;                      ///< 0: not armed
  Ticks received = 0;                               ///< when the request's last byte was
  Ticks started = kNoTicks;                         ///< of the train that plays, or played last
  Ticks burst_started = kNoTicks;                   ///< the gate's edge
  std::array<std::uint16_t, kTrackCount> played{};  ///< edges of each track
  std::uint16_t lost_inputs = 0;                    ///< input edges that had no room, since the start
  std::uint16_t next_input = 0;                     ///< the number that the next input edge will have
};

/// An input's edge; sensors and gate tell their active edges only.
struct InputEdge {
  std::uint16_t number = 0;  ///< of the reports since the start, modulo 65536
  InputLine line = InputLine::key;
  std::uint8_t active = 0;
  Ticks time = 0;
};

struct Limits {
  std::array<std::uint32_t, kOutputCount> max_on_us{};
};
struct Load {
  static constexpr std::size_t kMaxEdges = 29;  ///< that a body has room for
  Track track = Track::movers;
  std::uint16_t first = 0;
  std::uint16_t count = 0;
  std::array<Edge, kMaxEdges> edges{};
};
struct Arm {
  std::array<std::uint16_t, kTrackCount> edges{};
  std::uint32_t crc = 0;
  std::uint8_t gated = 0;
};
struct Start {
  std::uint32_t challenge = 0;
  Ticks at = 0;
  Ticks gate_from = 0, gate_until = 0;  ///< after the start; a gate's edge outside of it starts nothing
};

// ---- frames ----

inline constexpr std::size_t kMaxBody = 240;
inline constexpr std::size_t kMaxFrame = kMaxBody + 6 + 2;  ///< on the wire, with the overhead and the zero

struct Frame {
  std::uint8_t kind = 0;
  std::uint8_t number = 0;
  std::uint8_t size = 0;
  std::array<std::uint8_t, kMaxBody> body{};
  std::span<const std::uint8_t> bytes() const { return {body.data(), size}; }
};

/// CRC-32 of IEEE 802.3; `before` is that of the bytes before.
std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);
/// Of a train: its edges as LOAD carries them, movers first.
std::uint32_t train_crc(std::span<const Edge> movers, std::span<const Edge> lamps);

/// Bytes on the wire, with the zero; the number written to `wire`.
std::size_t encode(const Frame& frame, std::span<std::uint8_t, kMaxFrame> wire);

/// Takes a byte at a time, and whatever comes: damaged frames are counted and dropped.
class Decoder {
 public:
  /// The frame that this byte completes, if it does; valid until the next call.
  const Frame* take(std::uint8_t byte);
  std::uint32_t damaged() const { return damaged_; }

 private:
  std::array<std::uint8_t, kMaxFrame> raw_{};
  std::size_t size_ = 0;
  bool too_long_ = false;
  std::uint32_t damaged_ = 0;
  Frame frame_;
};

// ---- bodies ----

// To a frame of that kind (its number is the caller's to set), and back: nullopt if the body is no such one.
Frame to_frame(Request request);  ///< of those without a body, and HELLO
Frame to_frame(const Limits& limits);
Frame to_frame(const Load& load);
Frame to_frame(const Arm& arm);
Frame to_frame(const Start& start);
Frame to_frame(const Identity& identity);
Frame to_frame(const Status& status);
Frame to_frame(const InputEdge& edge);
std::optional<std::uint8_t> read_hello(const Frame& frame);  ///< the host's version
std::optional<Limits> read_limits(const Frame& frame);
std::optional<Load> read_load(const Frame& frame);
std::optional<Arm> read_arm(const Frame& frame);
std::optional<Start> read_start(const Frame& frame);
std::optional<Identity> read_identity(const Frame& frame);
std::optional<Status> read_status(const Frame& frame);
std::optional<InputEdge> read_input(const Frame& frame);

}  // namespace strobe::flash_sequencer
