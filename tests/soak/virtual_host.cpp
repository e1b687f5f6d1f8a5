#include "tests/soak/virtual_host.hpp"

#include <strobe_msgs/event_t.hpp>

#include "common/messages/channels.hpp"

namespace strobe::soak {

namespace {

// as in `strobe fire`: the first status may take half of it
constexpr std::int64_t kSecond_ns = 1'000'000'000;

}  // namespace

VirtualHost::VirtualHost(const HostSettings& settings, std::int64_t host_id, HostLog& log, Send send, Done done,
                         std::int64_t now_ns)
    : settings_(settings),
      log_(log),
      send_(std::move(send)),
      factory_(host_id),
      series_(settings.series, factory_),
      monitor_(settings.assembly, host_id, "soak"),
      decoder_(settings.rig, monitor_),
      started_ns_(now_ns) {
  for (const auto& [boot_id, sequence] : log_) monitor_.session().ledger().add(boot_id, sequence, 0);
  monitor_.on_shot_result = [this, done = std::move(done)](const host::ShotResult& shot_result) {
    done(shot_result);
    series_.on_shot_result(shot_result);
  };
  monitor_.on_event = [this](const strobe_msgs::event_t& event) {
    log_.emplace_back(event.boot_id, event.sequence);
    series_.on_event(event);
  };
  monitor_.on_notification = [this](const std::string& text) { notifications_.push_back(text); };
}

void VirtualHost::receive(const std::string& channel, const std::vector<std::uint8_t>& bytes,
                          std::int64_t now_ns) {
  decoder_.receive(channel, bytes.data(), bytes.size(), now_ns);
}

void VirtualHost::turn(std::int64_t now_ns) {
  monitor_.time(now_ns);
  if (const auto& status = monitor_.session().status()) {
    for (const EventRange& range : monitor_.session().ledger().due(now_ns))
      send_(factory_.resend(status->boot_id, range));
  }
  if (!series_.finished()) {
    const auto heard = monitor_.heard(now_ns);
    if (heard || now_ns - started_ns_ > kSecond_ns) series_.step(heard, now_ns);
  } else {
    collect(now_ns);
  }
  for (const auto& command : series_.take_commands()) send_(command);
  for (std::string& text : series_.take_notifications()) notifications_.push_back(std::move(text));
}

void VirtualHost::collect(std::int64_t now_ns) {
  if (!recovery_) recovery_.emplace(now_ns);
  ended_ = recovery_->over(monitor_.session(), monitor_.heard(now_ns).has_value(), now_ns);
}

}  // namespace strobe::soak
