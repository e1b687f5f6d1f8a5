// strobe-bench loop: the child of the timing measurements (runs.hpp). Prints the loop's processor time in
// s, shots and aborted shots, then commanded and issue start of every flash in ns.
#include <poll.h>
#include <pthread.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "firmware/core/rig.hpp"
#include "firmware/core/sequencer.hpp"
#include "firmware/linux/event_fd.hpp"
#include "firmware/linux/gpio_inputs.hpp"
#include "firmware/linux/gpio_outputs.hpp"
#include "firmware/linux/real_time.hpp"
#include "firmware/linux/system_clock.hpp"
#include "firmware/linux/tick_finder.hpp"
#include "firmware/publisher/loop_queue.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/benchmarks/timing/runs.hpp"

namespace {

using namespace strobe;
using namespace strobe::firmware;
using benchmarks::timing::LoopSettings;

constexpr std::int64_t kHost = 1;
constexpr int kPatientTurns = 20;
constexpr Duration kRest = milliseconds(350);  // between shots, which no lab fires one upon the other

Rig rig_for(const LoopSettings& settings) {
  const auto bin = std::filesystem::canonical("/proc/self/exe").parent_path();
  const std::string path = bin / "../share/strobe/rig.toml";
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  auto rig = read_rig(text.str(), path);
  if (!rig) throw std::runtime_error(rig.error().message);
  rig->plan.period = settings.period;
  rig->plan.dry = true;
  rig->tolerance.spin = settings.spin;
  if (settings.wake_ahead) rig->tolerance.wake_ahead = *settings.wake_ahead;
  rig->real_time.priority = settings.priority;
  rig->real_time.cpu = settings.cpu;
  return *rig;
}

/// ARM and FIRE in turn, as the state allows. The loop's thread only.
class Operator final : public CommandSource {
 public:
  explicit Operator(const ShotPlan& plan) : plan_(plan) {}
  void see(State state) { state_ = state; }
  bool pop(Command& command) noexcept override {
    if (state_ == State::firing || asked_ == state_) return false;
    asked_ = state_;
    command = Command();
    command.kind = state_ == State::armed   ? CommandKind::fire
                   : state_ == State::fault ? CommandKind::clear
                                            : CommandKind::arm;
    command.host_id = kHost;
    command.command_id = ++last_command_;
    command.new_token = last_command_;
    command.token = last_command_ - 1;
    command.plan = plan_;
    return true;
  }
  void forget() { asked_.reset(); }

 private:
  ShotPlan plan_;
  State state_ = State::idle;
  std::optional<State> asked_;
  std::int64_t last_command_ = 0;
};

struct Flash {
  MonoTime commanded, start;
};

/// Empties the loop's queue, as the publisher does.
class Collector {
 public:
  explicit Collector(LoopQueue& queue, EventFd& wake) : queue_(queue), wake_(wake) {
    flashes.reserve(1'000'000);
  }
  void run(const std::atomic<bool>& stop) {
    while (!stop) {
      pollfd waiting{wake_.fd(), POLLIN, 0};
      poll(&waiting, 1, 50);
      wake_.take();
      take_all();
    }
    take_all();
  }

  std::vector<Flash> flashes;
  int shots = 0, aborted = 0;

 private:
  void take_all() {
    LoopQueue::Item item;
    while (queue_.pop(item)) {
      if (const auto* event = std::get_if<Event>(&item)) {
        if (event->kind == EventKind::shot_aborted) aborted_at_ = event->device_time;
      } else if (auto* const* record = std::get_if<ShotRecord*>(&item)) {
        add(**record);
        queue_.give_back(*record);
      }
    }
  }
  void add(const ShotRecord& shot) {
    ++shots;
    for (const FlashRecord& flash : shot.flashes) {
      if (known(flash.issue_start)) {
        flashes.push_back({flash.commanded, flash.issue_start});
        continue;
      }
      // The one that was too late to be issued.
      ++aborted;
      if (aborted_at_ > flash.commanded) flashes.push_back({flash.commanded, aborted_at_});
      break;
    }
  }

  LoopQueue& queue_;
  EventFd& wake_;
  MonoTime aborted_at_;
};

double thread_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

int run_loop(const LoopSettings& settings) {
  keep_memory();
  const Rig rig = rig_for(settings);
  EventFd loop_wake;
  EventFd publisher_wake;
  auto lines = GpioOutputs::open(rig);
  if (!lines) throw std::runtime_error(lines.error().message);
  auto inputs = GpioInputs::open(rig, loop_wake.fd());
  if (!inputs) throw std::runtime_error(inputs.error().message);
  SystemClock clock;
  LoopQueue queue(rig, publisher_wake);
  Operator commands(rig.plan);
  TimedOutputs outputs(rig, clock, *lines);
  Sequencer sequencer(rig, {clock, outputs, **inputs, queue, commands}, 0, find_tick(rig.real_time));
  Collector collector(queue, publisher_wake);
  std::string faults = lock_memory();
  const LatencyRequest latency;
  std::atomic<bool> stop{false};
  std::thread collecting([&] { collector.run(stop); });
  double cpu_s = 0.0;
  std::thread loop([&] {
    faults += pin_to_cpu(settings.cpu) + become_real_time(settings.priority);
    prefault_stack();
    sequencer.start("bench");
    const double before_s = thread_cpu_s();
    const MonoTime end = clock.now() + milliseconds(1000) * settings.seconds;
    State last = State::fault;
    MonoTime rested = clock.now();
    for (int turns_as_is = 0; clock.now() < end; ++turns_as_is) {
      // Asked again where the answer was no, e.g. because the last shot is still being collected.
      if (sequencer.state() != last || turns_as_is == kPatientTurns) {
        commands.forget();
        turns_as_is = 0;
      }
      if (sequencer.state() != State::firing && last == State::firing) rested = clock.now() + kRest;
      last = sequencer.state();
      commands.see(clock.now() < rested ? State::firing : last);
      if (!sequencer.step(last == State::firing ? kNoDeadline : clock.now() + milliseconds(1))) break;
    }
    cpu_s = thread_cpu_s() - before_s;
    sequencer.stop("bench");
  });
  loop.join();
  stop = true;
  publisher_wake.wake();
  collecting.join();
  if (!faults.empty()) std::fprintf(stderr, "strobe-bench: warning: %s\n", faults.c_str());
  std::printf("%.6f %d %d\n", cpu_s, collector.shots, collector.aborted);
  for (const Flash& flash : collector.flashes)
    std::printf("%lld %lld\n", static_cast<long long>(to_ns(flash.commanded)),
                static_cast<long long>(to_ns(flash.start)));
  return 0;
}

}  // namespace

namespace strobe::benchmarks {

void add_loop_command(CLI::App& app, int& exit_status) {
  struct Options {
    LoopSettings settings;
    double period_us = 3000, spin_us = 200;
    std::optional<double> wake_ahead_us;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("loop", "one run of the loop, for timing and spin")->group("");
  command->add_option("--seconds", options->settings.seconds)->check(CLI::Range(1, 3600));
  command->add_option("--priority", options->settings.priority)->check(CLI::Range(1, 98));
  command->add_option("--cpu", options->settings.cpu)->check(CLI::Range(-1, 1023));
  command->add_option("--period-us", options->period_us)->check(CLI::Range(1500.0, 1e6));
  command->add_option("--spin-us", options->spin_us)->check(CLI::Range(0.0, 1000.0));
  command->add_option("--wake-ahead-us", options->wake_ahead_us)->check(CLI::Range(0.0, 20000.0));
  command->callback([options, &exit_status] {
    timing::LoopSettings settings = options->settings;
    settings.period = nanoseconds(static_cast<std::int64_t>(options->period_us * 1e3));
    settings.spin = nanoseconds(static_cast<std::int64_t>(options->spin_us * 1e3));
    if (options->wake_ahead_us)
      settings.wake_ahead = nanoseconds(static_cast<std::int64_t>(*options->wake_ahead_us * 1e3));
    exit_status = run_loop(settings);
  });
}

}  // namespace strobe::benchmarks
