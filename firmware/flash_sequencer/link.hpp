// The link to a flash sequencer as the loop uses it: requests and their answers, the newest status, edges of
// the inputs, the relation of the clocks.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>

#include "common/flash_sequencer/protocol.hpp"
#include "common/result.hpp"
#include "firmware/flash_sequencer/clock_agreement.hpp"
#include "firmware/flash_sequencer/clock_relation.hpp"
#include "firmware/flash_sequencer/heartbeat.hpp"
#include "firmware/flash_sequencer/serial_line.hpp"
#include "firmware/ports/clock.hpp"

namespace strobe::firmware {

/// Cuts the outputs. Returns false if it could not be written. Real-time safe and async-signal-safe, from any
/// thread and process that has the line.
bool send_abort(SerialLine& line) noexcept;

/// Real-time safe but for make_inactive() and connect(); one thread's.
class FlashSequencerLink {
 public:
  /// Without an answer for so long a request is sent again.
  static constexpr Duration kAnswerTime = milliseconds(6);
  /// What a status says is not relied on for longer. Key and e-stop act in the sequencer meanwhile.
  static constexpr Duration kFresh = milliseconds(200);

  /// All must outlive this.
  FlashSequencerLink(SerialLine& line, Heartbeat& heartbeat, Clock& clock)
      : line_(line), heartbeat_(heartbeat), clock_(clock) {}

  /// Cuts the outputs, again and again until the sequencer says that they are inactive. Fails after
  /// `patience`.
  Result<void> make_inactive(Duration patience);
  /// Likewise, and until its clock is related to the machine's. Sends beats itself: before the heartbeat's
  /// thread is started. Fails too if the sequencer speaks another version.
  Result<void> connect(Duration patience);

  /// Takes what has come. Returns false if the line is gone.
  bool take() noexcept;
  /// As SerialLine's.
  bool wait(MonoTime until) noexcept { return line_.wait(until); }
  bool poll(MonoTime until) noexcept { return line_.poll(until); }

  /// Sends the request with a number of its own; what was asked before is no longer waited for.
  void ask(const flash_sequencer::Frame& request) noexcept;
  /// The answer to the newest request, once; that to HELLO refuses nothing.
  std::optional<flash_sequencer::Status> take_answer() noexcept;
  /// Sends a request again that is not answered in time.
  void ask_again() noexcept;
  MonoTime answer_due() const noexcept { return waiting_ ? asked_at_ + kAnswerTime : MonoTime::max(); }
  void ask_nothing() noexcept { waiting_ = false; }
  bool abort() noexcept { return send_abort(line_); }

  /// The newest one. Valid: heard() is known.
  const flash_sequencer::Status& status() const noexcept { return status_; }
  MonoTime heard() const noexcept { return heard_; }  ///< when it came; kNoTime: none did
  /// For how long no status had come when it was last looked for: a machine that stood still has heard none.
  Duration silence() const noexcept { return known(heard_) ? looked_ - heard_ : Duration::max(); }
  const ClockRelation& clock_relation() const noexcept { return looked_ < held_until_ ? held_ : relation_; }
  /// Until then stamps mean what they mean now: a shot's times are related by one straight line.
  void hold_clock_relation(MonoTime until) noexcept;
  /// An edge that the kernel stamped as well.
  void witness(flash_sequencer::Ticks ticks, MonoTime kernel_stamp) noexcept;
  /// Of those of the shot before; by them the clocks are related from then on.
  const ClockAgreement& agreement() const noexcept { return agreement_; }
  /// Whether the sequencer was started anew since the last call of this.
  bool take_reset() noexcept { return std::exchange(was_reset_, false); }

  /// Of its newest start, as it last said: its program hung, and the watchdog started it anew. Valid:
  /// connect() succeeded, and no reset since.
  bool reset_by_watchdog() const noexcept { return identity_ && identity_->reset_by_watchdog != 0; }

  /// Levels as the newest status or edge tells: bits of InputLine.
  std::uint8_t inputs() const noexcept { return inputs_; }
  /// The oldest edge that was not taken; in order of their coming.
  bool take_edge(flash_sequencer::InputEdge& edge) noexcept;
  bool has_edges() const noexcept { return edge_count_ > 0; }
  std::int64_t lost_edges() const noexcept { return lost_edges_ + lost_there_; }

 private:
  Result<void> turn_for(Duration duration);
  static constexpr std::size_t kEdges = 256;

  void hear(const flash_sequencer::Frame& frame, MonoTime heard) noexcept;
  void hear(const flash_sequencer::Status& status, const flash_sequencer::Frame& frame,
            MonoTime heard) noexcept;
  void hear(const flash_sequencer::InputEdge& edge) noexcept;
  void keep(const flash_sequencer::InputEdge& edge) noexcept;
  void note_cut() noexcept;
  void note_gate() noexcept;
  void hear(const flash_sequencer::Identity& identity, std::uint8_t number) noexcept;
  void answered(std::uint8_t number, const flash_sequencer::Status& status) noexcept;
  void expect_edge(std::uint16_t number) noexcept;
  void started_anew() noexcept;

  SerialLine& line_;
  Heartbeat& heartbeat_;
  Clock& clock_;
  flash_sequencer::Decoder decoder_;
  ClockRelation relation_;
  ClockRelation held_, base_;  ///< base_: as held_, but by what the line tells alone
  MonoTime held_until_ = kNoTime;
  ClockAgreement agreement_, running_;

  flash_sequencer::Frame request_;
  bool waiting_ = false;
  MonoTime asked_at_;
  std::optional<flash_sequencer::Status> answer_;

  std::optional<flash_sequencer::Identity> identity_;
  flash_sequencer::Status status_;
  MonoTime heard_ = kNoTime, looked_ = kNoTime;
  bool was_reset_ = false;

  std::uint8_t inputs_ = 0;
  std::array<flash_sequencer::InputEdge, kEdges> edges_{};
  std::size_t first_edge_ = 0, edge_count_ = 0;
  std::optional<std::uint16_t> next_edge_;
  static constexpr flash_sequencer::Ticks kSameGate = flash_sequencer::ticks_of_us(20);
  static constexpr flash_sequencer::Ticks kNever = -(flash_sequencer::Ticks{1} << 60);
  flash_sequencer::Ticks last_gate_ = kNever;
  std::int64_t lost_edges_ = 0, lost_there_ = 0;
};

}  // namespace strobe::firmware
