// The hosts of the lab, the persons at them, and what the network brings them.
#include <algorithm>
#include <strobe_msgs/shot_t.hpp>

#include "common/messages/channels.hpp"
#include "tests/soak/lab_parts.hpp"

namespace strobe::soak {

namespace {

constexpr Duration kHostTurn = milliseconds(20);
constexpr Duration kHostBatch = milliseconds(1);
constexpr std::size_t kOldCommands = 64;
constexpr int kMaxCommands = 300;  // that an operator gives before he gives up
constexpr std::string_view kConfirmed = "disarmed: the firmware confirms it";

}  // namespace

MonoTime Lab::hosts_due() const { return std::min({host_.due, other_host_.due, watcher_.due}); }

void Lab::start(HostMachine& machine, const HostSettings& settings) {
  const std::int64_t host_id = random_.id();
  trace("host {:x} starts", host_id);
  const auto send = [this](std::span<const std::uint8_t> sealed) {
    if (asleep_) return;  // nobody listens
    std::vector<std::uint8_t> bytes(sealed.begin(), sealed.end());
    trace_command(bytes);
    bus_.send(Receiver::firmware, messages::channel_name(files_.host.rig, messages::Channel::command), bytes,
              time_);
    old_commands_.push_back(std::move(bytes));
    if (old_commands_.size() > kOldCommands) old_commands_.pop_front();
  };
  const bool counts = &machine == &host_;
  const auto done = [this, counts](const host::Shot& result) {
    if (counts) on_shot_result(result);
  };
  end(machine);
  if (settings.series) {
    ++counts_.acts;
    checker_.acted(host_id, time_);
  }
  ++counts_.hosts;
  machine.process = std::make_unique<VirtualHost>(settings, host_id, lab_key_, machine.log, send, done,
                                                  machine.read(world()));
  machine.due = std::max(time_, machine.wakes);
  schedule_changed_ = true;
}

void Lab::end(HostMachine& machine) {
  if (machine.process) checker_.host_gone(machine.process->id());
  machine.process.reset();
  machine.due = kFarFuture;
}

void Lab::start_host() {
  host_settings_.series->shots =
      std::max(1, settings_.shots - good_);  // one that starts anew wants at least one
  start(host_, host_settings_);
}

void Lab::start_other_series() {
  if (other_host_.process && !other_host_.process->ended()) return;
  HostSettings settings = host_settings_;
  settings.series->shots = random_.integer(1, 3);
  start(other_host_, settings);
}

void Lab::start_watcher() {
  HostSettings settings = host_settings_;
  settings.series.reset();
  start(watcher_, settings);
}

/// The operator fires anew, mostly where key and e-stop allow it, and not before a stop of his own is done with.
void Lab::give_command() {
  command_due_ = false;
  if (hazards_stopped_ && host_.process) return;
  const bool ready =
      key_ && !estop_ && !(host_.process && host_.process->disarming() && !host_.process->ended());
  if (time_ >= host_.wakes && (ready || random_.chance(0.02))) return start_host();
  command_due_ = true;
  in(random_.between(milliseconds(50), milliseconds(500)), Action::give_command);
}

void Lab::host_turn() {
  for (HostMachine* machine : {&host_, &other_host_, &watcher_})
    if (machine->due <= time_) step(*machine);
}

void Lab::step(HostMachine& machine) {
  machine.due = time_ + kHostTurn;
  VirtualHost& process = *machine.process;
  const host::HostReading now = machine.read(world());
  process.step(now);
  for (const std::string& text : process.take_notifications()) {
    trace("host {:x}: {}", process.id(), text);
    if (text.starts_with(kConfirmed)) checker_.confirmation_shown(process.id());
  }
  checker_.shows(process.id(), !process.danger().empty(), now.mono);
  if (!process.fault().empty()) {
    checker_.violate("a host threw on a message: " + process.fault());
    finished_ = true;
  }
  judge_series();
}

/// Whether the run is over, or the operator has to act again.
void Lab::judge_series() {
  if (!host_.process) return;
  const VirtualHost& process = *host_.process;
  const bool enough = process.series().succeeded();
  if (!process.firing() && !hazards_stopped_ && (enough || counts_.acts >= kMaxCommands)) {
    if (!enough) ++counts_.unfinished;
    stop_hazards();
  }
  if (!process.firing() && !hazards_stopped_ && !std::exchange(command_due_, true))
    in(nanoseconds(std::llround(random_.log_uniform(0.05, 3.0) * 1e9)), Action::give_command);
  const bool others_ended = !other_host_.process || other_host_.process->ended();
  if (hazards_stopped_ && process.ended() && others_ended) finished_ = true;
}

void Lab::stop_at(HostMachine& machine, Hazard way) {
  if (!machine.process || time_ < machine.wakes) return;
  VirtualHost& process = *machine.process;
  if (way == Hazard::page_disarm) process.disarm("a page");
  if (way == Hazard::stop_at_once) {
    if (process.ended()) return;
    process.stop_at_once();
  }
  if (way == Hazard::ctrl_c && !process.interrupt()) return;
  checker_.stop_asked(process.id(), machine.read(world()).mono, time_);
}

void Lab::sleep(HostMachine& machine) {
  if (time_ < machine.wakes) return;
  const Duration duration = nanoseconds(std::llround(random_.log_uniform(1.5, 20.0) * 1e9));
  machine.wakes = time_ + duration;
  machine.slept = machine.slept + duration;  // nobody reads its clock until then
  if (!machine.process) return;
  machine.due = machine.wakes;
  checker_.host_sleeps(machine.process->id(), machine.wakes);
}

/// The firmware's machine: its clock stands still, and the bench with it; the hosts go on.
void Lab::sleep() {
  if (dead_ || asleep_) return;
  checker_.suspended(time_);
  asleep_ = true;
  const Duration until = slept_ + nanoseconds(std::llround(random_.log_uniform(1.5, 20.0) * 1e9));
  while (slept_ < until) {
    slept_ = slept_ + kHostTurn;
    for (HostMachine* machine : {&host_, &other_host_, &watcher_})
      if (machine->process && machine->wakes <= time_) step(*machine);
  }
  asleep_ = false;
}

void Lab::mend_network() {
  if (hazards_stopped_) return;
  const FaultPlan& faults = settings_.faults;
  bus_.set_faults({faults.packet_loss, faults.packet_duplication, faults.packet_reordering});
}

// What the network brings -----------------------------------------------------------------------------------

void Lab::deliver() {
  const VirtualBus::Delivery delivery = bus_.take();
  const auto& [channel, bytes, flights] = *delivery.packet;
  switch (delivery.to) {
    case Receiver::firmware:
      if (dead_) break;
      checker_.at_firmware(body_of(bytes), time_);
      firmware_->receive(bytes);
      break;
    case Receiver::host:
      if (host_.process && host_.wakes <= time_) checker_.at_host(channel, bytes);
      to_host(host_, channel, bytes);
      break;
    case Receiver::other_host:
      to_host(other_host_, channel, bytes);
      break;
    case Receiver::watcher:
      to_host(watcher_, channel, bytes);
      break;
    case Receiver::tablet: {
      strobe_msgs::shot_t shot;
      if (shot.decode(bytes.data(), 0, static_cast<int>(bytes.size())) >= 0)
        tablet_operator_.announce({shot.boot_id, shot.shot_id}, from_ns(shot.start_ns), time_);
      break;
    }
  }
  bus_.done(delivery);
}

void Lab::to_host(HostMachine& machine, const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  if (!machine.process || time_ < machine.wakes) return;
  machine.process->receive(channel, bytes, machine.read(world()));
  machine.due = std::min(machine.due, time_ + kHostBatch);
}

void Lab::send_to_host(const std::string& channel, std::span<const std::uint8_t> packet) {
  for (const HostMachine* machine : {&host_, &other_host_, &watcher_})
    if (machine == &host_ || machine->process) bus_.send(machine->receiver, channel, packet, time_);
  const auto send = [this](const Stranger::Packet& sent) {
    ++counts_.strangers;
    strangers_bus_.send(Receiver::host, sent.channel, sent.bytes, time_);
  };
  const FaultPlan& faults = settings_.faults;
  if (faults.strangers > 0.0 && stranger_.random().chance(faults.strangers))
    send(stranger_.forge(channel, packet));
  if (faults.played_back > 0.0 && stranger_.random().chance(faults.played_back))
    send(stranger_.of_yesterday(channel, packet));
}

void Lab::deliver_strangers() {
  const VirtualBus::Delivery delivery = strangers_bus_.take();
  // Not looked at sooner for it, so that what the lab draws does not depend on strangers.
  if (host_.process && host_.wakes <= time_)
    host_.process->receive(delivery.packet->channel, delivery.packet->bytes, host_.read(world()));
  strangers_bus_.done(delivery);
}

}  // namespace strobe::soak
