// The status message: state of the loop, the journal and the timing at one instant. Pure except for the
// clocks where named; allocates; not real-time.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <strobe_msgs/status_t.hpp>
#include <vector>

#include "firmware/core/shot_timing.hpp"
#include "firmware/ports/clock.hpp"
#include "firmware/publisher/journal_folder.hpp"
#include "firmware/publisher/rejected_commands.hpp"

namespace strobe::firmware {

/// CLOCK_REALTIME, ns since 1970: metadata only.
std::int64_t system_wall_ns();
/// CLOCK_BOOTTIME: as CLOCK_MONOTONIC, but goes on while the machine is suspended.
std::int64_t system_boot_time_ns();

/// The machine's three clocks at one instant.
struct ClockReading {
  MonoTime mono;
  std::int64_t wall_ns = 0;
  std::int64_t boot_time_ns = 0;
};

/// Reads them within 20 us of each other, or as close together as the best of four attempts.
ClockReading read_clocks(Clock& clock, const std::function<std::int64_t()>& wall_ns,
                         const std::function<std::int64_t()>& boot_time_ns);

struct StatusParts {
  std::int64_t boot_id = 0;
  std::int64_t last_sequence = 0;  ///< journalled
  ClockReading clocks;
  LoopStatus loop;
  bool real_time = false;
  std::string journal_fault;  ///< empty if it can be written
  std::int64_t queue_overflows = 0;
  RejectedCommands rejected;
  std::vector<EarlierBoot> earlier;  ///< newest first; the message has the first 16
};

/// In microseconds; without values all are NaN and there are no bins.
strobe_msgs::histogram_t to_message(TimingQuantity quantity, const TimingHistogram& histogram);

/// The last message of each histogram, made anew only once a value was added: percentiles cost more than the rest
/// of a status.
class HistogramMessages {
 public:
  const strobe_msgs::histogram_t& of(TimingQuantity quantity, const TimingHistogram& histogram);

 private:
  std::map<TimingQuantity, strobe_msgs::histogram_t> last_;
};

strobe_msgs::status_t to_message(const StatusParts& parts, const ShotTiming& timing,
                                 HistogramMessages& histograms);

}  // namespace strobe::firmware
