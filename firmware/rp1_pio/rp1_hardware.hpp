// The port of the flash sequencer's logic to a Raspberry Pi 5's PIO block: tracks by two of its machines, and
// two that watch e-stop, key and heartbeat, and write zeros to the outputs once one of them fails. Its clock
// is CLOCK_MONOTONIC, so that the kernel's stamps of the inputs are its own; the block's cycles are related
// to it by counts that a machine keeps between trains.
#pragma once

#include <array>
#include <atomic>
#include <random>

#include "common/flash_sequencer/hardware.hpp"
#include "common/flash_sequencer/pio_programs.hpp"
#include "firmware/flash_sequencer/clock_relation.hpp"
#include "firmware/ports/clock.hpp"
#include "firmware/ports/edge_source.hpp"
#include "firmware/rp1_pio/pio_block.hpp"

namespace strobe::firmware {

/// GPIO numbers of the RP1.
struct Rp1Pins {
  static constexpr unsigned kNotFitted = ~0U;
  /// In the order of OutputLine; or kNotFitted. Active high; the pins of neither track lie between the
  /// other's.
  std::array<unsigned, flash_sequencer::kOutputCount> outputs{};
  unsigned key = 0, estop = 0;  ///< high allows
  unsigned gate = kNotFitted;
  bool gate_active_low = false;
};

struct Rp1PinSpan {
  unsigned first = 0, count = 0;
};

/// Cuts the outputs: they are driven low within a cycle of the block, and stay so. Async-signal-safe, from
/// any thread and process that has the block. Returns false if the block did not obey.
bool cut_outputs(PioBlock& block) noexcept;

/// One thread's but for clocks(). Allocates nothing; calls to the block may sleep for some 10 us each.
class Rp1Hardware final : public flash_sequencer::Hardware {
 public:
  using Ticks = flash_sequencer::Ticks;

  /// All must outlive this. seed: of random().
  Rp1Hardware(PioBlock& block, EdgeSource& edges, Clock& clock, const Rp1Pins& pins, std::uint64_t seed);
  /// Outputs are driven by the block from now on, low, and cut. Once, before all else. Returns false if the
  /// block did not obey.
  bool take() noexcept;
  /// To be called again and again. Sleeps first: until the instant, an input's edge, whatever else wakes the
  /// edge source, or something of its own is due; not at all if the instant has passed. Then feeds the
  /// watchers, begins the train at its instant, takes the inputs' edges, and watches the train's end.
  void poll(MonoTime until) noexcept;

  /// What it knows of its clocks' relation. From any thread.
  struct Clocks {
    Duration start_within{};  ///< the last train began within so much of the instant told
    double drift = 0.0;       ///< CLOCK_MONOTONIC against the block's clock: 1e-6 is 1 ppm
    double drift_sd = 0.0;
  };
  Clocks clocks() const noexcept;

  Ticks now() override;
  void prepare(std::span<flash_sequencer::Edge> movers, std::span<flash_sequencer::Edge> lamps) override;
  void start(Ticks at, bool gated) override;
  void listen_to_gate(bool listens) override;
  flash_sequencer::Progress progress() override;
  void cut() override;
  bool release() override;
  flash_sequencer::CutCause cut_by_itself() override;
  std::uint8_t inputs() override;
  std::uint8_t outputs() override;
  bool pop_input(flash_sequencer::InputEdge& edge) override;
  std::uint16_t lost_inputs() override;
  std::uint32_t random() override { return static_cast<std::uint32_t>(random_()); }

 private:
  using Edge = flash_sequencer::Edge;
  static constexpr std::size_t kTrackCount = flash_sequencer::kTrackCount;

  struct Track {
    std::array<std::uint32_t, 2 * flash_sequencer::kMaxEdges> words{};  ///< as its machine takes them
    std::span<const Edge> edges;
    std::int64_t first_cycles = 0;  ///< from the track's begin to its first edge
    Duration length{};
    std::size_t played = 0;  ///< edges whose time has come
    Duration next{};         ///< from the track's begin to the one after these
    MonoTime looked_at;      ///< for its end
    MonoTime queue_looked_at;
    int empty_looks = 0;  ///< at its machine's queue, the last ones
    bool ended = false;   ///< its word has come
    bool over = false;    ///< and the instant of its end was right, or it will never begin
    bool empty() const noexcept { return edges.empty(); }
  };
  /// When a machine had that count of cycles.
  struct Count {
    MonoTime not_before, not_after;
    std::uint32_t cycles = 0;
  };
  enum class Gate : std::uint8_t { closed, open, heard };

  bool set_up_watcher(unsigned machine, unsigned pin) noexcept;
  bool drive_outputs() noexcept;
  bool set_register(unsigned machine, flash_sequencer::pio::To to, std::uint32_t value) noexcept;
  bool set_up_player(std::size_t index, unsigned address) noexcept;
  std::optional<Count> count_of(unsigned machine) noexcept;
  void drain(unsigned machine) noexcept;

  MonoTime due() const noexcept;
  void take_edges(MonoTime until) noexcept;
  void feed_watchers() noexcept;
  void note_cut(flash_sequencer::CutCause cause) noexcept;
  void count_on() noexcept;
  bool begin_count() noexcept;
  double drift_sd(MonoTime at) const noexcept;

  void forget_train() noexcept;
  bool load(std::size_t index, std::span<const Edge> edges) noexcept;
  bool flush(unsigned machine) noexcept;
  std::uint32_t word_of(std::uint32_t levels, std::size_t index) const noexcept;
  std::int64_t cycles_in(Duration duration) const noexcept;
  void fail_train() noexcept { progress_.underrun = true; }
  bool aim(Duration lead) noexcept;
  Duration longest_lead() noexcept;
  MonoTime begin_due() const noexcept;
  void begin() noexcept;
  void enable_players(MonoTime planned) noexcept;
  void begun(MonoTime not_before, MonoTime not_after) noexcept;
  void keep_gate() noexcept;
  void open_gate() noexcept;
  void hear_gate() noexcept;
  void close_gate() noexcept;
  MonoTime begin_of(std::size_t index) const noexcept;
  MonoTime end_due(std::size_t index) const noexcept;
  void watch_train() noexcept;
  void watch_queue(std::size_t index) noexcept;
  void watch_end(std::size_t index) noexcept;
  std::size_t played(std::size_t index) noexcept;
  std::uint8_t planned_levels();

  PioBlock& block_;
  EdgeSource& edges_;
  Clock& clock_;
  const Rp1Pins pins_;
  Rp1PinSpan all_pins_;
  std::array<Rp1PinSpan, kTrackCount> track_pins_;
  std::mt19937_64 random_;

  bool cut_ = true;  ///< by the program
  bool cut_obeyed_ = false;
  flash_sequencer::CutCause cut_by_itself_ = flash_sequencer::CutCause::none;
  MonoTime fed_, feed_at_;

  std::array<Track, kTrackCount> tracks_;
  bool train_ = false;  ///< prepared or playing
  bool waits_ = false;  ///< for start_at_
  MonoTime start_at_;
  std::optional<Duration> lead_;  ///< of the players' start to start_at_, as they are set to
  int tries_ = 0;
  Duration aim_took_{};
  Duration half_call_{};  ///< until the players start
  bool gated_ = false;
  Gate gate_ = Gate::closed;
  bool gate_wanted_ = false;
  MonoTime gate_opened_, gate_stamp_ = kNoTime, gate_heard_ = kNoTime;
  MonoTime begin_ = kNoTime, burst_begin_ = kNoTime;
  flash_sequencer::Progress progress_;

  ClockRelation relation_;
  bool counts_ = false;
  std::uint32_t last_count_ = 0;
  std::int64_t counted_cycles_ = 0;
  MonoTime count_at_;
  double kept_drift_sd_ = kCrystalsSd;  ///< at drift_known_at_
  MonoTime drift_known_at_;
  static constexpr double kCrystalsSd = 60e-6;
  std::atomic<double> drift_{0.0}, drift_sd_{kCrystalsSd};
  std::atomic<std::int64_t> start_within_ns_{0};

  std::array<flash_sequencer::InputEdge, 128> inputs_;
  std::size_t first_input_ = 0, end_input_ = 0;
  std::uint16_t lost_inputs_ = 0;
};

}  // namespace strobe::firmware
