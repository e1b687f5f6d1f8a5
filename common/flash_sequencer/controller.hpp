// A flash sequencer's logic: requests in, replies out, and the guards between them. Nothing plays unless a
// whole train was loaded, checked against the limits, armed with key on and e-stop released, and started with
// the challenge that this arming drew; and it goes on playing only as long as beats come. What is cut stays
// cut until a reset. Deterministic: time and levels come from the hardware. No allocation. One thread's.
#pragma once

#include <array>

#include "common/flash_sequencer/hardware.hpp"
#include "common/flash_sequencer/protocol.hpp"

namespace strobe::flash_sequencer {

class Controller {
 public:
  /// boot: drawn for this start. Cuts the outputs: a reset comes first.
  Controller(Hardware& hardware, std::uint64_t boot, bool reset_by_watchdog);

  /// Carries out a request that was received completely at `received`, and gives its reply. False: it is no
  /// request, and gets none.
  bool answer(const Frame& request, Ticks received, Frame& reply);
  /// To be called again and again, at least every millisecond: heartbeat, key and e-stop, the train's end.
  void turn();
  /// The next input edge to be told. False: none.
  bool next_input(Frame& report);

  Phase phase() const { return phase_; }

 private:
  Refusal carry_out(const Frame& request);
  Refusal limits(const Frame& request);
  Refusal load(const Frame& request);
  Refusal arm(const Frame& request);
  Refusal start(const Frame& request);
  Refusal reset();
  Refusal forbidden();  ///< by key, e-stop or missing beats
  bool beats_come(Ticks now) const;
  void watch_heartbeat(Ticks now);
  void watch_train();
  bool played_all(Track track) const;
  std::span<Edge> edges(Track track);
  void end_train();
  void disarm();
  void cut(CutCause cause);
  Status status(Request answers, Refusal refusal, Ticks received);

  struct Loaded {
    std::array<Edge, kMaxEdges> edges{};
    std::size_t count = 0;
    Ticks length = 0;
    void clear() {
      count = 0;
      length = 0;
    }
  };

  Hardware& hardware_;
  Identity identity_;
  Phase phase_ = Phase::cut;
  CutCause cut_ = CutCause::none;
  Limits limits_;
  std::array<Loaded, kTrackCount> tracks_;
  std::uint32_t challenge_ = 0;
  bool gated_ = false;
  Start start_;
  bool listening_ = false;
  Ticks armed_at_ = 0;
  Ticks last_beat_ = kNoTicks;
  Progress progress_;
  std::uint16_t next_input_ = 0;
  std::optional<Frame> last_request_;
  Frame last_reply_;
};

}  // namespace strobe::flash_sequencer
