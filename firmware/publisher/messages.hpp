// From the loop's records, and the state of loop, journal and timing at one instant, to LCM messages. Pure
// but for the clocks where named; they allocate; thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>
#include <vector>

#include "common/shot/shot_key.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/core/shot_timing.hpp"
#include "firmware/ports/clock.hpp"
#include "firmware/ports/event_sink.hpp"
#include "firmware/publisher/journal_folder.hpp"
#include "firmware/publisher/rejections.hpp"

namespace strobe::firmware {

strobe_msgs::event_t to_message(const Event& event, std::int64_t boot_id, std::int64_t sequence);

strobe_msgs::shot_t to_message(const ShotRecord& record, const Rig& rig, std::int64_t boot_id,
                               SequenceRange sequences, const std::vector<Note>& notes);

/// The rig file's notes; the command's replace those of the same key and follow otherwise.
std::vector<Note> merged(const std::vector<Note>& rig_record, const std::vector<Note>& command);

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

/// The last message of each histogram, made anew only once a value was added: percentiles cost more than the
/// rest of a status.
class HistogramMessages {
 public:
  const strobe_msgs::histogram_t& of(TimingQuantity quantity, const TimingHistogram& histogram);

 private:
  std::map<TimingQuantity, strobe_msgs::histogram_t> last_;
};

strobe_msgs::status_t to_message(const StatusParts& parts, const ShotTiming& timing,
                                 HistogramMessages& histograms);

}  // namespace strobe::firmware
