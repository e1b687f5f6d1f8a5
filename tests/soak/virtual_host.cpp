#include "tests/soak/virtual_host.hpp"

#include "common/messages/channels.hpp"

namespace strobe::soak {

VirtualHost::VirtualHost(const HostSettings& settings, std::int64_t host_id, const authentication::Key& key,
                         HostLog& log, Send send, Done done, const host::HostReading& now)
    : log_(log),
      send_(std::move(send)),
      done_(std::move(done)),
      now_(now),
      command_channel_(messages::channel_name(settings.rig, messages::Channel::command)),
      loop_({settings.rig, settings.assembly, host_id, settings.series.has_value(), key}, *this, *this) {
  if (settings.series) runner_.emplace(loop_, *settings.series);
  loop_.add_listener(*this);
  for (const auto& [boot_id, sequence] : log_) loop_.session().ledger().add(boot_id, sequence, HostTime{});
}

void VirtualHost::receive(const std::string& channel, Bytes bytes, const host::HostReading& now) {
  now_ = now;
  loop_.receive(channel, bytes);
}

void VirtualHost::step(const host::HostReading& now) {
  now_ = now;
  loop_.step();
  if (runner_) runner_->step();
}

bool VirtualHost::interrupt() {
  if (!runner_->firing() || !runner_->series().shot_under_way()) return runner_->stop("the operator");
  runner_->end_after_shot("interrupted");
  return false;
}

void VirtualHost::publish(const std::string& channel, Bytes bytes) {
  if (channel == command_channel_) send_(bytes);
}

void VirtualHost::on_event(const strobe_msgs::event_t& event) {
  log_.emplace_back(event.boot_id, event.sequence);
}

}  // namespace strobe::soak
