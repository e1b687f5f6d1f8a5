// Lateness samples with the span of time in which a freeze of the machine would explain them, and what is
// made of them: percentiles, rows, curves, and whether the kernel held them up.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <vector>

#include "common/units/time.hpp"
#include "tests/benchmarks/timing/freeze_detector.hpp"

namespace strobe::benchmarks::timing {

struct Sample {
  MonoTime from;  ///< a freeze that touches [from, to] ...
  MonoTime to;    ///< ... may have caused this lateness
  double lateness_us = 0.0;
  int cpu = -1;  ///< where it ran; -1: not known, a freeze of any core may have
};

/// Due at one instant, done at the other.
Sample sample_of(MonoTime due, MonoTime done, int cpu);

struct Percentiles {
  std::size_t count = 0;
  double p50_us = 0.0, p99_us = 0.0, p999_us = 0.0, max_us = 0.0;
};

/// Nearest-rank percentiles; zeros where there are no samples.
Percentiles percentiles(std::vector<double> lateness_us);

std::vector<double> latenesses(const std::vector<Sample>& samples);
/// Of those that no freeze touches.
std::vector<double> outside(const std::vector<Sample>& samples, const std::vector<Freeze>& freezes);

void append(std::vector<Sample>& to, const std::vector<Sample>& from);

/// Of figures, printed as a table, as JSON, or as CSV.
struct Row {
  std::string load, what;
  std::string freezes;  ///< "left out" or "included"
  Percentiles lateness;
  double cpu_percent = -1.0;  ///< negative: not measured
  std::string ratio;          ///< of p50/p99/p99.9/max to the reference's; empty: not computed
};

/// Each of the first's percentiles over the second's, as "0.001 0.02 0.1 0.9".
std::string ratios(const Percentiles& of, const Percentiles& to);

/// `ratio_to` heads the ratios.
void print_rows(const std::vector<Row>& rows, bool json, const std::string& ratio_to = "over cyclictest's");
/// std::runtime_error if it cannot be written.
void write_csv(const std::string& path, const std::vector<Row>& rows);

/// Drawn as SVG.
struct Curve {
  std::string title;
  std::vector<double> x;
  std::vector<double> y;
};

struct Panel {
  std::string title, x_label, y_label;
  bool log_x = true, log_y = true;
  std::vector<Curve> curves;
};

/// The share of values that are above each, for values from 1 ns up.
Curve exceedance(const std::string& title, std::vector<double> values);

/// One panel beside the other, with its data as CSV beside it. std::runtime_error if it cannot be written.
void draw(const std::string& svg, const std::vector<Panel>& panels);

/// A flash of strobed's journal as a sample: its issue; also of one that was too late to be issued, for which
/// its shot was aborted: it counts as issued then, since the latest flashes would be missing otherwise.
/// Returns nullopt for all other events.
std::optional<Sample> flash_of(const strobe_msgs::event_t& event, int cpu);

/// Whether the kernel was running on a core while something on it was late, though the core did not freeze.
struct KernelActivity {
  std::size_t late = 0;        ///< samples later than the limit, outside freezes, of a known core
  std::size_t interrupts = 0;  ///< taken by their core between due and done
  std::size_t in_kernel = 0;   ///< of these, how many interrupted the kernel
};

/// `interrupts`: of each core. All counts are 0 without them, or if no sample's core is known.
KernelActivity kernel_activity(const std::vector<Sample>& samples, const std::vector<Freeze>& freezes,
                               const std::vector<std::vector<CoreInterrupt>>& interrupts, Duration limit);

/// "31 later than 100 us outside freezes, meanwhile their core was in the kernel at 40 of 41 looks"
std::string in_words(const KernelActivity& held, Duration limit);

/// How long after whole seconds cyclictest wakes: off the kernel's tick.
inline constexpr Duration kAfterSecond = microseconds(500);

/// cyclictest's wake-ups, from the lateness of each in their order and when the first was heard of: it prints
/// no instants, but began at a whole second of CLOCK_MONOTONIC and half a millisecond, waits for every period
/// from there, and leaves out those that have passed before it is done with the last. So that a freeze is
/// looked for in the same span as for a flash: from the instant it was due.
std::vector<Sample> wake_ups_of(const std::vector<Duration>& lateness, MonoTime first_heard, Duration period,
                                int cpu);

}  // namespace strobe::benchmarks::timing
