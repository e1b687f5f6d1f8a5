// strobe-bench clock: how well the host knows the firmware's clock, on simulated heartbeats whose truth is
// known: errors, stated sds, and the errors that a plain least-squares line makes of the same heartbeats.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <memory>
#include <string_view>
#include <vector>

#include "tests/benchmarks/command.hpp"
#include "tests/host/heartbeats.hpp"

namespace strobe::studies {
namespace {

using host_test::Heartbeats;

struct Delays {
  std::string_view words;
  double lost_share, long_share, burst_share, wander;
};
constexpr std::array<Delays, 6> kDelays{{{"100 us ± 20 us", 0.0, 0.0, 0.0, 0.0},
                                         {"and a fifth lost", 0.2, 0.0, 0.0, 0.0},
                                         {"and 15 % late by 2 ms (mean)", 0.05, 0.15, 0.0, 0.0},
                                         {"and bursts of ten, 5-10 ms late", 0.05, 0.15, 0.02, 0.0},
                                         {"the first, wander .05 ppm/sqrt(s)", 0.0, 0.0, 0.0, 0.05e-6},
                                         {"bursts and wander", 0.05, 0.15, 0.02, 0.05e-6}}};
constexpr std::array<int, 8> kHeard{3, 5, 10, 20, 40, 60, 120, 240};

struct Errors {
  std::vector<double> errors, sds;
  void add(double error, double sd) {
    errors.push_back(error);
    sds.push_back(sd);
  }
  double mean() const {
    double sum = 0.0;
    for (const double error : errors) sum += error;
    return sum / static_cast<double>(errors.size());
  }
  double rms() const {
    double sum = 0.0;
    for (const double error : errors) sum += error * error;
    return std::sqrt(sum / static_cast<double>(errors.size()));
  }
  double stated() const {
    double sum = 0.0;
    for (const double sd : sds) sum += sd * sd;
    return std::sqrt(sum / static_cast<double>(sds.size()));
  }
  double rms_in_sds() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < errors.size(); ++i) sum += std::pow(errors[i] / sds[i], 2);
    return std::sqrt(sum / static_cast<double>(errors.size()));
  }
};

/// Slope of the least-squares line through the beats, less 1.
double plain_drift(const std::vector<Heartbeats::Beat>& beats) {
  const auto n = static_cast<double>(beats.size());
  double mx = 0.0, my = 0.0, sxx = 0.0, sxy = 0.0;
  const auto x = [&](const Heartbeats::Beat& b) {
    return to_seconds(b.device.mono - beats.front().device.mono);
  };
  const auto y = [&](const Heartbeats::Beat& b) {
    return to_seconds((b.heard - beats.front().heard) - (b.device.mono - beats.front().device.mono));
  };
  for (const auto& b : beats) mx += x(b) / n, my += y(b) / n;
  for (const auto& b : beats) sxx += (x(b) - mx) * (x(b) - mx), sxy += (x(b) - mx) * (y(b) - my);
  return sxy / sxx;
}

/// Errors of the clock's state after `beats` received heartbeats.
void study(const Delays& delays, int beats, int pairs) {
  Errors drift, offset, plain;
  for (int pair = 1; pair <= pairs; ++pair) {
    Heartbeats sender(static_cast<unsigned>(pair));
    sender.drift = 1e-6 * (pair % 101 - 50);
    sender.lost_share = delays.lost_share;
    sender.long_share = delays.long_share;
    sender.burst_share = delays.burst_share;
    sender.wander = delays.wander;
    host::DeviceClock clock;
    std::vector<Heartbeats::Beat> heard;
    while (static_cast<int>(heard.size()) < beats) {
      const auto beat = sender.next();
      if (!beat) continue;
      heard.push_back(*beat);
      clock.on_heartbeat(sender.boot_id, beat->device, beat->heard);
    }
    const host::ClockState state = clock.state();
    if (!state.drift_ppm) continue;
    drift.add(*state.drift_ppm - 1e6 * sender.drift, state.drift_sd_ppm);
    // The delay that all messages have cannot be distinguished from the offset.
    offset.add(1e6 * (*state.offset_s - sender.offset_s() - Heartbeats::kDelay_s), 1e6 * state.offset_sd_s);
    plain.add(1e6 * (plain_drift(heard) - sender.drift), 1.0);
  }
  if (drift.errors.empty()) return;
  fmt::print("{:<34} {:>5} {:>9.3f} {:>9.3f} {:>6.2f} {:>12.3f} {:>10.1f} {:>9.1f} {:>6.2f} {:>9.1f}\n",
             delays.words, beats, drift.rms(), drift.stated(), drift.rms_in_sds(), plain.rms(), offset.rms(),
             offset.stated(), offset.rms_in_sds(), offset.mean());
}

}  // namespace

void add_clock_command(CLI::App& app, int& exit_status) {
  auto pairs = std::make_shared<int>(1000);
  CLI::App* command = app.add_subcommand(
      "clock", "How well the host knows the firmware's clock, over simulated pairs of machines");
  command->add_option("--pairs", *pairs, "pairs of clocks in each row (default 1000)")
      ->check(CLI::Range(2, 1000000));
  command->footer("Example: strobe-bench clock --pairs 1000");
  command->callback([pairs, &exit_status] {
    fmt::print("{:<34} {:>5} {:>26} {:>12} {:>27} {:>9}\n", "", "", "drift, ppm", "least sq.", "offset, us",
               "offset,");
    fmt::print("{:<34} {:>5} {:>9} {:>9} {:>6} {:>12} {:>10} {:>9} {:>6} {:>9}\n",
               "delays (beats 0.5 s apart)", "heard", "rms error", "stated", "z rms", "rms error",
               "rms error", "stated", "z rms", "mean");
    for (const Delays& delays : kDelays)
      for (const int beats : kHeard) study(delays, beats, *pairs);
    exit_status = 0;
  });
}

}  // namespace strobe::studies
