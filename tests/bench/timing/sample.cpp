#include "tests/bench/timing/sample.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <stdexcept>
#include <strobe_msgs/event_t.hpp>

#include "tests/bench/timing/clock.hpp"

namespace strobe::bench {

Percentiles percentiles(std::vector<double> lateness_us) {
  if (lateness_us.empty()) return {};
  std::sort(lateness_us.begin(), lateness_us.end());
  const auto rank = [&](double p) {
    const double position = std::ceil(p * static_cast<double>(lateness_us.size()));
    return lateness_us[static_cast<std::size_t>(std::max(1.0, position)) - 1];
  };
  return {lateness_us.size(), rank(0.5), rank(0.99), rank(0.999), lateness_us.back()};
}

FlashSamples flashes_of_journal(const std::string& path) {
  lcm::LogFile log(path, "r");
  if (!log.good()) throw std::runtime_error(path + ": cannot be read");
  FlashSamples samples;
  while (const lcm::LogEvent* entry = log.readNextEvent()) {
    if (!entry->channel.ends_with("/EVENT")) continue;
    strobe_msgs::event_t event;
    if (event.decode(entry->data, 0, entry->datalen) < 0 || event.kind != strobe_msgs::event_t::FLASH)
      continue;
    const auto late_us = [&](std::int64_t at_ns) {
      return static_cast<double>(at_ns - event.commanded_ns) * 1e-3;
    };
    const MonoTime from{event.commanded_ns};
    samples.issue.push_back({from, {event.issue_start_ns}, late_us(event.issue_start_ns)});
    samples.done.push_back({from, {event.issue_end_ns}, late_us(event.issue_end_ns)});
  }
  return samples;
}

std::vector<Sample> run_cyclictest(int priority, Duration period, int seconds) {
  const std::string command = "cyclictest -m -q -v -u -N -t 1 -p " + std::to_string(priority) + " -i " +
                              std::to_string(period.ns / 1000) + " -D " + std::to_string(seconds) +
                              " 2>/dev/null";
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

}  // namespace strobe::bench
