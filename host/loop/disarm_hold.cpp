#include "host/loop/disarm_hold.hpp"

#include <fmt/format.h>

namespace strobe::host {

void DisarmHold::disarm(const std::string& from) {
  const auto status = loop_.live_status();
  if (!status) return loop_.notify("cannot be disarmed, as " + from + " asks: no firmware heard");
  holds_ = true;
  until_ = loop_.now() + kHold;
  send(*status);
  const bool active = status->arm_token != 0 || status->state == strobe_msgs::status_t::FIRING;
  loop_.notify(fmt::format("{} by {}; what is armed within {} s is disarmed, too",
                           active ? "disarmed" : "nothing was armed as it was disarmed", from,
                           std::chrono::duration_cast<std::chrono::seconds>(kHold).count()));
}

void DisarmHold::step() {
  if (!holds_) return;
  if (loop_.now() >= until_) {
    holds_ = false;
    return;
  }
  const auto status = loop_.live_status();
  if (status && status->arm_token != 0 && status->arm_token != token_) send(*status);
}

void DisarmHold::send(const strobe_msgs::status_t& status) {
  token_ = status.arm_token;
  loop_.send(loop_.commands().disarm(status.boot_id));
}

}  // namespace strobe::host
