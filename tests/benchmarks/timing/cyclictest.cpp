#include "tests/benchmarks/timing/cyclictest.hpp"

#include <array>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include "tests/benchmarks/timing/clock.hpp"

namespace strobe::benchmarks::timing {

namespace {

constexpr Duration kAfterSecond = microseconds(500);

}  // namespace

std::vector<Sample> wake_ups_of(const std::vector<Duration>& lateness, MonoTime first_heard, Duration period,
                                int cpu) {
  if (lateness.empty()) return {};
  const MonoTime latest_begin = first_heard - lateness.front() - period - kAfterSecond;
  MonoTime due = std::chrono::floor<std::chrono::seconds>(latest_begin) + kAfterSecond + period;
  std::vector<Sample> samples;
  for (const Duration late : lateness) {
    const MonoTime woken = due + late;
    samples.push_back(sample_of(due, woken, cpu));
    due = due + period;
    while (woken > due) due = due + period;
  }
  return samples;
}

std::vector<Sample> run_cyclictest(const LoopSettings& like) {
  // chrt: the load must not hold its printing thread up for seconds, which would make the first line's second
  // another one.
  std::string command = "chrt -f 5 cyclictest -m -q -v -u -N -t 1 --secaligned=" +
                        std::to_string(kAfterSecond / microseconds(1)) + " -p " +
                        std::to_string(like.priority) + " -i " +
                        std::to_string(like.period / microseconds(1)) + " -D " + std::to_string(like.seconds);
  if (like.cpu >= 0) command += " -a " + std::to_string(like.cpu);
  command += " 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
  if (!pipe) throw std::runtime_error("cyclictest cannot be started (Debian package rt-tests)");
  std::vector<Duration> lateness;
  MonoTime first_heard;
  std::array<char, 256> line{};
  while (std::fgets(line.data(), static_cast<int>(line.size()), pipe.get())) {
    int thread = 0;
    long index = 0;
    long lateness_ns = 0;
    if (std::sscanf(line.data(), " %d: %ld: %ld", &thread, &index, &lateness_ns) != 3) continue;
    if (lateness.empty()) first_heard = now();
    if (index != static_cast<long>(lateness.size()))
      throw std::runtime_error("cyclictest left wake-ups out of what it printed");
    lateness.push_back(nanoseconds(lateness_ns));
  }
  if (lateness.empty())
    throw std::runtime_error("cyclictest printed no samples (Debian package rt-tests; needs root or rtprio)");
  return wake_ups_of(lateness, first_heard, like.period, like.cpu);
}

}  // namespace strobe::benchmarks::timing
