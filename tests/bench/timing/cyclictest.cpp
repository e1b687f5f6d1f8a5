#include "tests/bench/timing/cyclictest.hpp"

#include <array>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include "tests/bench/timing/clock.hpp"

namespace strobe::bench::timing {

std::vector<Sample> run_cyclictest(const LoopSettings& like) {
  // chrt: the load must not hold its printing thread up, or samples would be blamed on later freezes.
  std::string command = "chrt -f 5 cyclictest -m -q -v -u -N -t 1 --secaligned=500 -p " +
                        std::to_string(like.priority) + " -i " + std::to_string(like.period.ns / 1000) +
                        " -D " + std::to_string(like.seconds);
  if (like.cpu >= 0) command += " -a " + std::to_string(like.cpu);
  command += " 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
  if (!pipe) throw std::runtime_error("cyclictest cannot be started (Debian package rt-tests)");
  // Its printing thread looks every 10 ms: a sample is at most that, and some scheduling, older than its
  // line.
  constexpr Duration kPrintDelay = milliseconds(15);
  std::vector<Sample> samples;
  std::array<char, 256> line{};
  while (std::fgets(line.data(), static_cast<int>(line.size()), pipe.get())) {
    int thread = 0;
    long index = 0;
    long lateness_ns = 0;
    if (std::sscanf(line.data(), " %d: %ld: %ld", &thread, &index, &lateness_ns) != 3) continue;
    const MonoTime arrival = now();
    samples.push_back(
        {arrival - kPrintDelay - nanoseconds(lateness_ns), arrival, static_cast<double>(lateness_ns) * 1e-3});
  }
  if (samples.empty())
    throw std::runtime_error("cyclictest printed no samples (Debian package rt-tests; needs root or rtprio)");
  return samples;
}

}  // namespace strobe::bench::timing
