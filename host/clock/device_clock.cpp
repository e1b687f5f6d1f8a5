#include "host/clock/device_clock.hpp"

#include <algorithm>

namespace strobe::host {

const DeviceClock::Boot* DeviceClock::find(std::int64_t boot_id) const {
  const auto found = std::ranges::find(boots_, boot_id, &Boot::id);
  return found == boots_.end() ? nullptr : &*found;
}

DeviceClock::Boot DeviceClock::first_heard(std::int64_t boot_id, const DeviceReading& device,
                                           HostTime heard) const {
  const bool same_clock = !boots_.empty() && boots_.back().relation->may_hold_for(device, heard);
  return {boot_id, same_clock ? boots_.back().relation : std::make_shared<ClockRelation>()};
}

void DeviceClock::on_heartbeat(std::int64_t boot_id, const DeviceReading& device, HostTime heard) {
  if (!find(boot_id)) {
    boots_.push_back(first_heard(boot_id, device, heard));
    if (boots_.size() > kMaxBoots) boots_.pop_front();
  }
  ClockRelation& relation = *find(boot_id)->relation;
  relation.on_heartbeat(device, heard);
  for (std::string& text : relation.take_notifications()) notifications_.push_back(std::move(text));
}

void DeviceClock::on_local(const HostReading& local) {
  const auto change = local_watch_.on_reading(local);
  if (!change) return;
  for (std::string& text : in_words(*change, "this machine")) notifications_.push_back(std::move(text));
}

std::optional<HostTime> DeviceClock::local(std::int64_t boot_id, MonoTime device) const {
  const Boot* boot = find(boot_id);
  return boot ? std::optional(boot->relation->local(device)) : std::nullopt;
}

ClockState DeviceClock::state() { return boots_.empty() ? ClockState() : boots_.back().relation->state(); }

bool DeviceClock::suspended_within(std::int64_t boot_id, MonoTime from, MonoTime to) const {
  const Boot* boot = find(boot_id);
  return boot && boot->relation->suspended_within(from, to);
}

}  // namespace strobe::host
