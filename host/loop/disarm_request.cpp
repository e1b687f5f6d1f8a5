#include "host/loop/disarm_request.hpp"

namespace strobe::host {

using strobe_msgs::status_t;

void DisarmRequest::begin(HostTime now, std::int64_t boot_id, std::int64_t boot_time_ns) {
  if (!asked_) asked_ = now;
  sent_ = now - kRepeat;
  boot_id_ = boot_id;
  boot_time_ns_ = boot_time_ns;
}

bool DisarmRequest::due(HostTime now) {
  if (!asked_ || now - sent_ < kRepeat) return false;
  sent_ = now;
  return true;
}

bool DisarmRequest::on_status(const status_t& status) {
  if (!asked_ || status.state != status_t::STOPPED) return false;
  // One that was under way as the DISARM was asked for says nothing of it.
  if (status.boot_id == boot_id_ && status.boot_time_ns <= boot_time_ns_) return false;
  asked_.reset();
  return true;
}

std::string DisarmRequest::not_confirmed(HostTime now) const {
  if (!asked_ || now - *asked_ < kConfirmWithin) return "";
  return "DISARM NOT CONFIRMED: the rig does not answer and may still be armed or fire; press the e-stop";
}

}  // namespace strobe::host
