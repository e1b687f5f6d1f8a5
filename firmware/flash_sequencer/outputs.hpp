// Pulses played by a flash sequencer: a shot's whole train is loaded before its first instant, started by the
// sequencer's clock, and told as the sequencer says that it was played.
#pragma once

#include <array>
#include <utility>

#include "firmware/core/rig.hpp"
#include "firmware/flash_sequencer/link.hpp"
#include "firmware/flash_sequencer/train_edges.hpp"
#include "firmware/ports/scheduled_outputs.hpp"

namespace strobe::firmware {

/// What is issued has start and end alike: the sequencer's stamp. Allocates in its constructor only.
class FlashSequencerOutputs : public ScheduledOutputs {
 public:
  /// Outputs that the sequencer does not say to be inactive so long after it was asked to cut them are
  /// broken. Time in which the loop did not turn does not count.
  static constexpr Duration kCutTime = milliseconds(100);

  /// All must outlive this.
  FlashSequencerOutputs(const Rig& rig, FlashSequencerLink& link, Clock& clock);

  Duration lead(const PulseSchedule& schedule) const noexcept override;
  void begin(const PulseSchedule& schedule, MonoTime start, Listener& listener) noexcept override;
  void add(std::size_t first) noexcept override;
  void tell(Listener& listener) noexcept override;
  void run(Listener& listener) noexcept override;
  MonoTime next_due() const noexcept override;
  bool all_issued() const noexcept override;
  bool cut() noexcept override;
  bool active(Output output) const noexcept override;
  bool broken() const noexcept override { return broken_; }
  const char* take_failure() noexcept override;
  ShortText clock_words() const noexcept override;

 private:
  enum class Step { idle, hello, limits, reset, load, arm, start, playing, cutting };
  using Track = flash_sequencer::Track;
  using Change = TrainEdges::Change;

  bool under_way() const noexcept { return step_ != Step::idle && step_ != Step::cutting; }
  bool loading() const noexcept { return under_way() && step_ != Step::playing; }
  const TrainEdges& train(Track track) const noexcept { return trains_[static_cast<std::size_t>(track)]; }

  void ask(Step step, const flash_sequencer::Frame& request) noexcept;
  void go_on(const flash_sequencer::Status& answer, Listener& listener) noexcept;
  void load(Track track, std::size_t first) noexcept;
  void loaded() noexcept;
  void arm() noexcept;
  void start(std::uint32_t challenge, Listener& listener) noexcept;
  bool all_allowed(Listener& listener) noexcept;
  flash_sequencer::Start start_request() noexcept;
  void give_up(Listener& listener, const ShortText& why, MonoTime late_for = kNoTime) noexcept;

  void play(Listener& listener) noexcept;
  bool tell_next(Listener& listener) noexcept;
  void tell(const Change& change, Track track, Listener& listener) noexcept;
  const Change* next_played(Track track) const noexcept;
  flash_sequencer::Ticks begin_of(Track track) const noexcept;
  bool all_told() const noexcept;

  bool may_be_on(Output output) const noexcept;
  bool is_cut() const noexcept;
  void look() noexcept;
  void end() noexcept;

  FlashSequencerLink& link_;
  Clock& clock_;
  flash_sequencer::Limits limits_;
  std::array<TrainEdges, flash_sequencer::kTrackCount> trains_;

  Step step_ = Step::idle;
  const PulseSchedule* schedule_ = nullptr;  ///< of the shot under way, or being cut
  MonoTime start_;
  flash_sequencer::Load asked_to_load_;
  bool asked_to_start_ = false;
  MonoTime gate_counts_from_;
  std::size_t first_of_burst_ = kNotAdded;  ///< gated: in the schedule's pulses

  std::array<std::size_t, flash_sequencer::kTrackCount> told_{};  ///< changes of each track
  std::array<bool, kOutputs.size()> on_{};                        ///< as told
  std::array<flash_sequencer::Ticks, kOutputs.size()> on_at_{};   ///< of its track

  std::array<bool, kOutputs.size()> may_be_on_{};  ///< until a cut is confirmed
  MonoTime cut_at_, asked_to_cut_at_, looked_at_;
  Duration waited_for_cut_{};
  bool broken_ = false;
  const char* failure_ = nullptr;

  static constexpr std::size_t kNotAdded = static_cast<std::size_t>(-1);
};

}  // namespace strobe::firmware
