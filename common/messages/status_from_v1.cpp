#include "common/messages/status_from_v1.hpp"

#include <limits>

namespace strobe::messages {
namespace {

using strobe_msgs::histogram_t;
using strobe_msgs::status_t;
using strobe_msgs::status_v1_t;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

histogram_t lateness_of(const status_v1_t& old) {
  histogram_t lateness{};
  lateness.quantity = histogram_t::LATENESS;
  lateness.count = old.edges_issued;
  lateness.mean_us = lateness.sd_us = lateness.min_us = kNone;
  lateness.p50_us = old.lateness_p50_us;
  lateness.p99_us = old.lateness_p99_us;
  lateness.p999_us = old.lateness_p999_us;
  lateness.max_us = old.lateness_max_us;
  lateness.bin_first_us = lateness.bin_width_us = kNone;
  return lateness;
}

}  // namespace

status_t status_from_v1(const status_v1_t& old) {
  status_t status{};
  status.schema_version = status_t::SCHEMA_VERSION;
  status.boot_id = old.boot_id;
  status.last_sequence = old.last_sequence;
  status.mono_ns = old.mono_ns;
  status.wall_ns = old.wall_ns;
  status.boot_time_ns = old.mono_ns;
  status.state = old.state;
  status.key_active = old.key_active;
  status.estop_active = old.estop_active;
  status.arm_host_id = old.arm_host_id;
  status.arm_token = old.arm_token;
  status.arm_expires_ns = old.arm_expires_ns;
  status.last_shot_id = old.last_shot_id;
  status.real_time = old.real_time;
  status.journal_ok = old.journal_ok;
  status.queue_overflows = old.queue_overflows;
  status.kernel_overflows = old.kernel_overflows;
  status.histograms = {lateness_of(old)};
  status.histogram_count = 1;
  status.message = old.message;
  return status;
}

}  // namespace strobe::messages
