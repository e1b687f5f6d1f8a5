// The virtual lab: firmware core, publisher and journal, the rig, a lossy bus, the host that fires a series
// and the tablet operator, in one process on one virtual clock. Deterministic from a seed: no clock is read,
// nothing depends on the machine's load.
//
// The firmware's loop drives the clock: while it sleeps, polls or spins, everything that is due until then is
// processed, in order of time, on the same thread. Virtual time jumps from one scheduled item to the next;
// otherwise it passes only as the loop's own calls take. One thread's; allocates.
#pragma once

#include <cstdio>
#include <deque>
#include <memory>
#include <optional>

#include "firmware/core/sequencer.hpp"
#include "sim/rig/rig.hpp"
#include "tests/soak/bus.hpp"
#include "tests/soak/counts.hpp"
#include "tests/soak/disk.hpp"
#include "tests/soak/lab_setup.hpp"
#include "tests/soak/firmware_process.hpp"
#include "tests/soak/virtual_host.hpp"
#include "tests/soak/invariant_checker.hpp"
#include "tests/soak/stranger.hpp"
#include "tests/soak/tablet_operator.hpp"
#include "tests/support/sealed_sender.hpp"

namespace strobe::soak {

/// The rig file as both sides read it.
struct RigFiles {
  firmware::Rig firmware;
  host::RigFile host;
};
Result<RigFiles> read_rig_files(const std::string& path);

struct RunSettings {
  std::uint64_t seed = 1;  ///< of the whole soak
  std::int64_t run = 0;    ///< number of the run, from 0
  int shots = 10;          ///< that must count
  FaultPlan faults;
  PlanKind plan = PlanKind::mixed;
  std::FILE* trace = nullptr;  ///< log of what happens; nullptr: none
};

class Lab final : firmware::Clock, firmware::OutputLines, firmware::EdgeSource, firmware::MessageBus {
 public:
  /// `files` must outlive the lab.
  Lab(const RigFiles& files, const RunSettings& settings);
  ~Lab() override;

  /// Runs to the end.
  SoakCounts run();

  InvariantChecker& invariant_checker() { return checker_; }

 private:
  enum class Action {
    draw_hazards,
    hazard,
    key_on,
    estop_off,
    disk_free,
    give_command,  ///< the operator, to fire
    network_back,
    firmware_kill,
    guardian,
    boot,
  };
  struct Scheduled {
    Action action = Action::draw_hazards;
    Hazard hazard = Hazard::key_off;
  };
  struct CallHazard {
    int calls_left;
    Hazard hazard;
  };
  struct Shot {
    MonoTime start, end;
    bool dry = false;
  };
  class PublisherClock;
  class PublisherWake;
  class LoopWake;

  // Ports of the firmware's loop
  MonoTime now() noexcept override;
  Duration suspended() noexcept override { return slept_; }
  MonoTime spin_until(MonoTime instant) noexcept override;
  bool set(firmware::Output output, bool active) noexcept override;
  bool set_lamps(strobe::Lamps lamps) noexcept override;
  std::optional<std::size_t> wait(MonoTime until, std::span<firmware::Edge> edges) noexcept override;
  std::optional<std::size_t> poll(MonoTime until, std::span<firmware::Edge> edges) noexcept override;
  std::optional<bool> level(firmware::Input input) noexcept override;
  std::int64_t kernel_overflows() const noexcept override { return overflows_; }
  // Port of the firmware's publisher
  void publish(const std::string& channel, std::span<const std::uint8_t> bytes) override;

  // Time
  void pass(Duration duration);
  void advance_to(MonoTime instant);
  MonoTime next();
  void process_next();
  void perform(const Scheduled& scheduled);
  void schedule(Duration delay, const Scheduled& scheduled) {
    timeline_.schedule(time_ + delay, scheduled);
    schedule_changed_ = true;
  }
  void in(Duration delay, Action action) { schedule(delay, {action, {}}); }

  // Bench
  void drive(firmware::Output output, bool active, strobe::Lamps lamps = strobe::Lamps::both);
  void set_key(bool on);
  void set_estop(bool pressed);
  void edge(firmware::Input input, bool active, MonoTime at);
  void collect_rig();
  std::size_t drain(std::span<firmware::Edge> edges);

  // Hazards
  void draw_hazards();
  void inject(Hazard hazard);
  void count_down_call_hazards();
  void stand_still(Duration duration, bool whole_machine);
  void stop_hazards();
  void sleep();

  // Processes
  void boot();
  void die();
  void stop_firmware();
  void guardian_takes_over();
  void publisher_turn();
  // Hosts
  void start(HostMachine& machine, const HostSettings& settings);
  void end(HostMachine& machine);
  void start_host();
  void start_other_series();
  void start_watcher();
  void mend_network();
  void give_command();
  void host_turn();
  void step(HostMachine& machine);
  void judge_series();
  void stop_at(HostMachine& machine, Hazard way);
  void sleep(HostMachine& machine);
  void to_host(HostMachine& machine, const std::string& channel, const std::vector<std::uint8_t>& bytes);
  MonoTime hosts_due() const;
  void deliver();
  void deliver_strangers();
  /// To the host, and whoever listens.
  void send_to_host(const std::string& channel, std::span<const std::uint8_t> packet);
  /// Of a sealed command; empty if it is none of this lab's.
  std::vector<std::uint8_t> body_of(const std::vector<std::uint8_t>& sealed) const;
  void trace_command(const std::vector<std::uint8_t>& sealed);
  void tablet_operator_turn();
  void note_shot(std::span<const std::uint8_t> bytes);
  void on_shot_result(const host::Shot& shot_result);
  bool over();
  void trace_lab_setup();
  void settle();
  /// As if the firmware's machine had not slept.
  MonoTime world() const { return time_ + slept_; }
  std::string trace_time() const;
  template <typename... Args>
  void trace(const char* format, const Args&... args);
  void mix(std::uint64_t value) { digest_ = mixed(digest_ ^ value, 1); }

  const RigFiles& files_;
  RunSettings settings_;
  Random random_;
  LabSetup lab_setup_;
  HostSettings host_settings_;
  MonoTime time_;
  MonoTime next_;                 ///< of everything that is scheduled
  bool schedule_changed_ = true;  ///< since next_ was found
  Timeline<Scheduled> timeline_;
  VirtualBus bus_;
  VirtualDisk disk_;
  sim::Rig rig_;
  VirtualTabletOperator tablet_operator_;
  InvariantChecker checker_;
  authentication::Key lab_key_ = authentication::Key::random();
  testing::SealedSender tablet_{lab_key_};
  Stranger stranger_;
  VirtualBus strangers_bus_;  ///< of its own, so that what the lab draws does not depend on strangers
  SoakCounts counts_;
  std::uint64_t digest_ = 0;

  bool key_ = true, estop_ = false;
  std::array<std::deque<firmware::Edge>, 6> kernel_;
  std::size_t waiting_edges_ = 0;
  std::int64_t overflows_ = 0;
  std::vector<sim::Drive> drives_;
  std::vector<sim::Exposure> exposures_;
  std::vector<CallHazard> call_hazards_;
  MonoTime still_until_;          ///< the loop
  MonoTime machine_still_until_;  ///< every process of the firmware's machine

  std::unique_ptr<FirmwareProcess> firmware_;
  std::unique_ptr<PublisherClock> publisher_clock_;
  std::unique_ptr<PublisherWake> publisher_wake_;
  std::unique_ptr<LoopWake> loop_wake_;
  std::array<bool, firmware::kOutputs.size()> driven_{};
  bool dead_ = true;  ///< the process has ended, its objects may still be unwinding
  bool stop_asked_ = false, woken_ = false;
  MonoTime publisher_due_ = kFarFuture;
  Duration publisher_latency_{};
  Duration wall_offset_{};

  Duration slept_{};  ///< the firmware's machine
  bool asleep_ = false;
  HostMachine host_, other_host_, watcher_;
  bool command_due_ = false;  ///< the operator will give it
  int good_ = 0;
  bool hazards_stopped_ = false, finished_ = false;
  std::map<ShotKey, Shot> shots_;
  std::deque<std::vector<std::uint8_t>> old_commands_;
  std::size_t violations_traced_ = 0;
};

}  // namespace strobe::soak
