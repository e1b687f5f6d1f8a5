#include "tests/benchmarks/timing/loop_run.hpp"

#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <stdexcept>
#include <thread>

#include "sim/scene/scene.hpp"
#include "tests/benchmarks/timing/clock.hpp"

namespace strobe::benchmarks::timing {

namespace {

sim::ChipSpec rig_chip() {
  sim::ChipSpec spec;
  for (const std::string_view name : sim::kLineNames) {
    const bool high = name == sim::name(sim::RigLine::key) || name == sim::name(sim::RigLine::estop);
    spec.lines.push_back({.name = std::string(name), .idle_level = high ? 1 : 0});
  }
  return spec;
}

sim::Chip make_chip(const std::filesystem::path& folder) {
  auto chip = sim::Chip::create(folder, rig_chip());
  if (!chip) throw std::runtime_error(chip.error().message);
  return std::move(*chip);
}

std::string command_line(const std::filesystem::path& folder, const LoopSettings& settings) {
  const auto library = sim::preload_path();
  if (!library) throw std::runtime_error(library.error().message);
  const std::string program = std::filesystem::canonical("/proc/self/exe");
  return std::string(sim::kChipDirVariable) + "='" + folder.string() + "' LD_PRELOAD='" + library->string() +
         "' '" + program + "' loop --seconds " + std::to_string(settings.seconds) + " --priority " +
         std::to_string(settings.priority) + " --cpu " + std::to_string(settings.cpu) + " --period-us " +
         std::to_string(settings.period / microseconds(1)) + " --spin-us " +
         std::to_string(settings.spin / microseconds(1)) +
         (settings.wake_ahead ? " --wake-ahead-us " + std::to_string(*settings.wake_ahead / microseconds(1))
                              : "") +
         (settings.outputs == Outputs::none ? " --no-outputs" : "") +
         (settings.tick_avoidance ? "" : " --any-start");
}

}  // namespace

struct LoopFixture::Waiter {
  explicit Waiter(const std::filesystem::path& folder)
      : chip(std::move(sim::Chip::attach(folder).value())), thread([this] { follow(); }) {}
  ~Waiter() {
    stop = true;
    thread.join();
  }
  void follow() {
    sim::ChangeCursor cursor = chip.cursor_now();
    std::vector<sim::Change> changes;
    while (!stop) {
      chip.wait_changes(cursor, now() + milliseconds(50), changes);
      changes.clear();
    }
  }
  sim::Chip chip;
  std::atomic<bool> stop{false};
  std::thread thread;
};

LoopFixture::LoopFixture(bool rig_waits)
    : folder_("/dev/shm/strobe-bench-loop-" + std::to_string(getpid())), chip_(make_chip(folder_)) {
  if (rig_waits) waiter_ = std::make_unique<Waiter>(folder_);
}

LoopFixture::~LoopFixture() = default;

LoopRun LoopFixture::run(const LoopSettings& settings) {
  const std::string command = command_line(folder_, settings);
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
  if (!pipe) throw std::runtime_error("cannot run: " + command);
  LoopRun run;
  double cpu_s = 0.0;
  if (std::fscanf(pipe.get(), "%lf %d %d", &cpu_s, &run.shots, &run.aborted) != 3)
    throw std::runtime_error("the loop did not run: " + command);
  std::int64_t commanded_ns = 0, start_ns = 0, end_ns = 0;
  while (std::fscanf(pipe.get(), "%ld %ld %ld", &commanded_ns, &start_ns, &end_ns) == 3) {
    const MonoTime commanded = from_ns(commanded_ns), start = from_ns(start_ns), end = from_ns(end_ns);
    run.issue.push_back(sample_of(commanded, start, settings.cpu));
    run.done.push_back(sample_of(commanded, end, settings.cpu));
    run.call.push_back(sample_of(start, end, settings.cpu));
  }
  if (run.issue.empty()) throw std::runtime_error("no flash was fired by: " + command);
  run.cpu_percent = 100.0 * cpu_s / (static_cast<double>(run.issue.size()) * to_seconds(settings.period));
  return run;
}

}  // namespace strobe::benchmarks::timing
