// What the simulated chip costs: a set of lines without and with a rig that waits for changes, and the way of
// an edge from the rig to a reader. Runs itself again with the library preloaded.
#include <benchmark/benchmark.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sim/gpiochip/chip.hpp"
#include "tests/sim/gpiochip/standard_chip.hpp"
#include "tests/sim/gpiochip/conformance/uapi_client.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;

MonoTime now() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return from_ns(time.tv_sec * 1'000'000'000 + time.tv_nsec);
}

/// Reads changes in a thread, as the rig does.
class WaitingRig {
 public:
  explicit WaitingRig(bool wanted) {
    if (!wanted) return;
    chip_.emplace(std::move(Chip::attach(std::getenv(kChipDirVariable)).value()));
    thread_ = std::thread([this] { follow(); });
  }
  ~WaitingRig() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::size_t seen() const { return seen_; }

 private:
  void follow() {
    ChangeCursor cursor = chip_->cursor_now();
    std::vector<Change> changes;
    while (!stop_) {
      chip_->wait_changes(cursor, now() + milliseconds(1), changes);
      seen_ += changes.size();
      changes.clear();
    }
  }

  std::optional<Chip> chip_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  std::atomic<std::size_t> seen_{0};
};

/// Arguments: number of lines, whether a rig waits.
void set_lines(benchmark::State& state) {
  const int chip = uapi::open_chip("/dev/gpiochip0");
  std::vector<unsigned> lines;
  for (unsigned line = 0; line < static_cast<unsigned>(state.range(0)); ++line) lines.push_back(line);
  const int handle = uapi::request_lines(chip, lines, GPIOHANDLE_REQUEST_OUTPUT);
  if (handle < 0) state.SkipWithError("cannot request the lines");
  {
    const WaitingRig rig(state.range(1) != 0);
    gpiohandle_data data{};
    for (auto _ : state) {
      std::fill(data.values, data.values + 4, static_cast<std::uint8_t>(1 - data.values[0]));
      benchmark::DoNotOptimize(ioctl(handle, GPIOHANDLE_SET_LINE_VALUES_IOCTL, &data));
    }
  }
  close(handle);
  close(chip);
}
BENCHMARK(set_lines)->ArgNames({"lines", "rig"})->Args({1, 0})->Args({4, 0})->Args({1, 1})->Args({4, 1});

/// One set every 200 µs, so that the rig sleeps and each set has to wake it.
void set_waking_the_rig(benchmark::State& state) {
  const int chip = uapi::open_chip("/dev/gpiochip0");
  const int handle = uapi::request_lines(chip, {0, 1}, GPIOHANDLE_REQUEST_OUTPUT);
  if (handle < 0) state.SkipWithError("cannot request the lines");
  {
    const WaitingRig rig(true);
    gpiohandle_data data{};
    std::vector<double> cost_ns;
    for (auto _ : state) {
      usleep(200);
      data.values[0] = data.values[1] = static_cast<std::uint8_t>(1 - data.values[0]);
      const MonoTime before = now();
      ioctl(handle, GPIOHANDLE_SET_LINE_VALUES_IOCTL, &data);
      const Duration cost = now() - before;
      cost_ns.push_back(static_cast<double>(cost.count()));
      state.SetIterationTime(to_seconds(cost));
    }
    std::sort(cost_ns.begin(), cost_ns.end());
    state.counters["p50_ns"] = cost_ns[cost_ns.size() / 2];
    state.counters["p99_ns"] = cost_ns[cost_ns.size() * 99 / 100];
  }
  close(handle);
  close(chip);
}
BENCHMARK(set_waking_the_rig)->UseManualTime()->Iterations(2'000);

/// From drive() to the reader's return from poll and read.
void edge_to_reader(benchmark::State& state) {
  const int chip = uapi::open_chip("/dev/gpiochip0");
  const int event = uapi::request_event(chip, 4, GPIOHANDLE_REQUEST_INPUT, GPIOEVENT_REQUEST_BOTH_EDGES);
  if (event < 0) state.SkipWithError("cannot request the line");
  Chip rig = std::move(Chip::attach(std::getenv(kChipDirVariable)).value());
  std::vector<double> latency_ns;
  std::atomic<bool> stop{false};
  std::atomic<int> answered{0};
  std::thread reader([&] {
    pollfd waiting{event, POLLIN, 0};
    gpioevent_data data{};
    while (!stop) {
      if (poll(&waiting, 1, 10) <= 0 || read(event, &data, sizeof(data)) != sizeof(data)) continue;
      latency_ns.push_back(static_cast<double>(to_ns(now()) - static_cast<std::int64_t>(data.timestamp)));
      ++answered;
    }
  });
  int driven = 0;
  for (auto _ : state) {
    usleep(200);
    const MonoTime stamp = now();
    rig.drive(4, ++driven % 2, stamp);
    while (answered < driven) std::this_thread::yield();
    state.SetIterationTime(latency_ns.back() * 1e-9);
  }
  stop = true;
  reader.join();
  std::sort(latency_ns.begin(), latency_ns.end());
  state.counters["p50_ns"] = latency_ns[latency_ns.size() / 2];
  state.counters["p99_ns"] = latency_ns[latency_ns.size() * 99 / 100];
  rig.drive(4, 0, now());
  close(event);
  close(chip);
}
BENCHMARK(edge_to_reader)->UseManualTime()->Iterations(2'000);

/// Makes the chip, in memory, where no write-back disturbs the figures, and runs this program again on it.
int run_preloaded(char** argv) {
  const std::filesystem::path folder = "/dev/shm/strobe-bench-" + std::to_string(getpid());
  const auto chip = Chip::create(folder, standard_chip());
  const auto library = preload_path();
  if (!chip || !library) {
    std::fprintf(stderr, "gpiochip_bench: %s\n", (chip ? library.error() : chip.error()).message.c_str());
    return 1;
  }
  const pid_t child = fork();
  if (child == 0) {
    setenv(kChipDirVariable, folder.c_str(), 1);
    setenv("LD_PRELOAD", library->c_str(), 1);
    execv("/proc/self/exe", argv);
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (std::getenv(kChipDirVariable) == nullptr) return run_preloaded(argv);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
