// The processes of the lab: firmware, its guardian, tablet operator; their starts and ends; hazards; results.
#include <algorithm>
#include <cmath>
#include <exception>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/shot_t.hpp>

#include "common/authentication/seal.hpp"
#include "common/messages/channels.hpp"
#include "host/session/shot.hpp"
#include "sim/rig/truth.hpp"
#include "tests/soak/lab_parts.hpp"

namespace strobe::soak {

using firmware::Output;

namespace {

constexpr Duration kHazardInterval = milliseconds(500);
constexpr Duration kLongestRun = milliseconds(1'800'000);

bool has_numbers(const reduction::Readout& readout) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    if (readout.value[static_cast<reduction::Quantity>(i)]) return true;
  return false;
}

/// A flash without an image, or with two, or with a fault of its time or sensor.
bool images_are_ambiguous(const sim::Scene& scene, const sim::Exposure& exposure) {
  using sim::FaultKind;
  return exposure.has(FaultKind::flash_dim) || exposure.has(FaultKind::flash_double) ||
         exposure.has(FaultKind::flash_late) || exposure.has(FaultKind::flash_missing) ||
         exposure.has(FaultKind::sensor_bounce) || exposure.has(FaultKind::sensor_dropout) ||
         shot_fault(scene.faults, FaultKind::image_unseen, exposure.shot) != nullptr;
}

}  // namespace

std::string Lab::trace_time() const {
  return fmt::format("{:14.6f}", static_cast<double>(to_ns(time_) - 1'000'000'000'000) * 1e-9);
}

// Hazards -----------------------------------------------------------------------------------------------------

void Lab::draw_hazards() {
  in(kHazardInterval, Action::draw_hazards);
  if (hazards_stopped_) return;
  for (std::size_t i = 0; i < kHazardCount; ++i) {
    const auto hazard = static_cast<Hazard>(i);
    if (!random_.chance(settings_.faults[hazard] * to_seconds(kHazardInterval))) continue;
    if (random_.chance(0.5))
      schedule(random_.between(Duration{}, kHazardInterval), {Action::hazard, hazard});
    else
      call_hazards_.push_back({random_.integer(1, 100), hazard});  // at an instant at which an output changes
  }
}

void Lab::count_down_call_hazards() {
  for (std::size_t i = 0; i < call_hazards_.size();) {
    if (--call_hazards_[i].calls_left > 0) {
      ++i;
      continue;
    }
    const Hazard hazard = call_hazards_[i].hazard;
    call_hazards_.erase(call_hazards_.begin() + static_cast<std::ptrdiff_t>(i));
    const Duration delay = random_.chance(0.5) ? Duration{} : random_.between(Duration{}, microseconds(60));
    schedule(delay, {Action::hazard, hazard});
  }
}

void Lab::stand_still(Duration duration, bool whole_machine) {
  if (dead_) return;
  checker_.stands_still(time_, time_ + duration);
  still_until_ = std::max(still_until_, time_ + duration);
  if (whole_machine) machine_still_until_ = std::max(machine_still_until_, time_ + duration);
}

void Lab::inject(Hazard hazard) {
  if (hazards_stopped_) return;
  ++counts_.hazards[static_cast<std::size_t>(hazard)];
  trace("hazard: {}", name(hazard));
  const auto soon = [this](double least_s, double most_s) {
    return nanoseconds(std::llround(random_.log_uniform(least_s, most_s) * 1e9));
  };
  switch (hazard) {
    case Hazard::key_off:
      set_key(false);
      return in(soon(1e-5, 2.0), Action::key_on);
    case Hazard::estop:
      set_estop(true);
      return in(soon(1e-5, 2.0), Action::estop_off);
    case Hazard::firmware_kill:
      return die();
    case Hazard::firmware_stop:
      stop_asked_ = woken_ = true;
      return;
    case Hazard::firmware_hang: {
      const Duration until_killed = random_.between(milliseconds(500), milliseconds(700));
      stand_still(until_killed, false);
      return in(until_killed, Action::firmware_kill);
    }
    case Hazard::loop_freeze:
      return stand_still(random_.between(milliseconds(10), milliseconds(170)), true);
    case Hazard::loop_delay:
      return stand_still(soon(20e-6, 5e-3), false);
    case Hazard::host_kill:
      end(host_);
      if (std::exchange(command_due_, true)) return;
      return in(soon(0.05, 1.0), Action::give_command);
    case Hazard::wall_step:
      wall_offset_ = wall_offset_ + random_.between(milliseconds(-86'400'000), milliseconds(86'400'000));
      return;
    case Hazard::disk_full:
      disk_.fill(static_cast<std::uint64_t>(random_.integer(0, 3000)));
      return in(soon(0.01, 2.0), Action::disk_free);
    case Hazard::command_replay:
      if (old_commands_.empty()) return;
      return bus_.send(Receiver::firmware,
                       messages::channel_name(files_.host.rig, messages::Channel::command),
                       old_commands_[static_cast<std::size_t>(random_.bits() % old_commands_.size())], time_);
    case Hazard::ctrl_c:
    case Hazard::stop_at_once:
      return stop_at(host_, hazard);
    case Hazard::page_disarm:
      return stop_at(watcher_, hazard);
    case Hazard::other_series:
      return start_other_series();
    case Hazard::firmware_suspend:
      return sleep();
    case Hazard::host_suspend:
      return sleep(host_);
    case Hazard::network_outage:
      bus_.set_faults({1.0, 0.0, 0.0});
      return in(soon(0.1, 5.0), Action::network_back);
  }
}

void Lab::perform(const Scheduled& scheduled) {
  switch (scheduled.action) {
    case Action::draw_hazards:
      return draw_hazards();
    case Action::hazard:
      return inject(scheduled.hazard);
    case Action::key_on:
      return set_key(true);
    case Action::estop_off:
      return set_estop(false);
    case Action::disk_free:
      return disk_.make_room();
    case Action::give_command:
      return give_command();
    case Action::network_back:
      return mend_network();
    case Action::firmware_kill:
      return die();
    case Action::guardian:
      return guardian_takes_over();
    case Action::boot:
      return boot();
  }
}

/// The run is over: no more hazards, so that what was lost can be fetched.
void Lab::stop_hazards() {
  hazards_stopped_ = true;
  trace("healed");
  call_hazards_.clear();
  bus_.set_faults({});
  disk_.make_room();
  set_key(true);
  set_estop(false);
  if (other_host_.process) other_host_.process->stop_at_once();
}

// Firmware --------------------------------------------------------------------------------------------------

void Lab::boot() {
  if (firmware_) return;
  FirmwareProcess::Settings settings(lab_key_);
  settings.boot_id = random_.id();
  settings.session = disk_.path();
  settings.draw_token = [this] {
    const std::int64_t token = random_.id();
    checker_.token_drawn(token, time_);
    return token;
  };
  settings.wall_ns = [this] { return 1'770'000'000'000'000'000 + to_ns(time_) + wall_offset_.count(); };
  settings.boot_time_ns = [this] { return to_ns(world()); };
  settings.say = [this](const std::string& line) { trace("strobed: {}", line); };
  disk_.write([&] {
    auto process = FirmwareProcess::start(
        files_.firmware, {*this, *this, *this, *this, *publisher_clock_, *loop_wake_, *publisher_wake_},
        settings);
    if (process) firmware_ = std::move(*process);
  });
  if (!firmware_) return in(milliseconds(500), Action::boot);
  ++counts_.boots;
  trace("boot {:x}", settings.boot_id);
  checker_.booted(settings.boot_id, time_);
  for (auto& buffer : kernel_) buffer.clear();
  waiting_edges_ = 0;
  overflows_ = 0;
  stop_asked_ = dead_ = false;
  still_until_ = machine_still_until_ = MonoTime{};
  publisher_due_ = time_;
}

void Lab::die() {
  if (dead_) return;
  dead_ = true;
  const int lost = firmware_->drop_queue();
  counts_.events_lost_dying += lost;
  trace("the firmware's process ends, {} events in its queue", lost);
  checker_.died(time_);
  publisher_due_ = kFarFuture;
  in(random_.between(microseconds(300), milliseconds(5)), Action::guardian);
}

void Lab::guardian_takes_over() {
  for (const Output output : firmware::kOutputs) drive(output, false);
  in(random_.between(milliseconds(300), milliseconds(1'200)), Action::boot);
}

void Lab::stop_firmware() {
  firmware_->loop().stop("stopped by a signal");
  if (dead_) return;
  disk_.write([this] { firmware_->publisher().finish(); });
  die();
}

void Lab::publisher_turn() {
  if (dead_) {
    publisher_due_ = kFarFuture;
    return;
  }
  if (time_ < machine_still_until_) {
    publisher_due_ = machine_still_until_;
    return;
  }
  publisher_due_ = kFarFuture;
  try {
    disk_.write([this] { firmware_->publisher().turn(); });
  } catch (const std::exception& error) {
    trace("the publisher throws: {}", error.what());
    return die();
  }
  publisher_due_ = std::min(publisher_due_, firmware_->publisher().next_turn());
  publisher_due_ = std::max(publisher_due_, time_ + microseconds(20));
}

// Commands, tablet operator and results ----------------------------------------------------------------------

void Lab::trace_command(const std::vector<std::uint8_t>& sealed) {
  if (settings_.trace == nullptr) return;
  const std::vector<std::uint8_t> body = body_of(sealed);
  strobe_msgs::command_t command;
  if (command.decode(body.data(), 0, static_cast<int>(body.size())) >= 0)
    trace("command {} of kind {}", command.command_id, static_cast<int>(command.kind));
}

std::vector<std::uint8_t> Lab::body_of(const std::vector<std::uint8_t>& sealed) const {
  const auto body = authentication::unseal(lab_key_, files_.host.rig, sealed);
  return body ? std::vector<std::uint8_t>(body->begin(), body->end()) : std::vector<std::uint8_t>();
}

void Lab::tablet_operator_turn() {
  const std::vector<std::uint8_t> frame = tablet_operator_.take(time_);
  if (frame.empty()) return;
  trace("frame sent");
  const std::string channel = messages::channel_name(files_.host.rig, messages::Channel::frame);
  send_to_host(channel, tablet_.packet(channel, authentication::Bytes(frame)));
}

void Lab::note_shot(std::span<const std::uint8_t> bytes) {
  strobe_msgs::shot_t shot;
  if (shot.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return;
  const bool news = shots_
                        .emplace(ShotKey{shot.boot_id, shot.shot_id},
                                 Shot{from_ns(shot.start_ns), time_, shot.plan.dry != 0})
                        .second;
  if (!news) return;
  ++counts_.shots;
  trace("shot {} is published{}{}", shot.shot_id, shot.aborted ? ", aborted: " : "", shot.abort_reason);
}

void Lab::on_shot_result(const host::Shot& shot_result) {
  if (shot_result.boot_id == stranger_.old_boot()) return;  // shown, and nobody's of this day
  if (shot_result.host_id == host_.process->id() && !shot_result.rejected) ++good_;
  const ShotKey key{shot_result.boot_id, shot_result.shot_id};
  const auto shot = shots_.find(key);
  const sim::Exposure* taken =
      shot == shots_.end() ? nullptr : tablet_operator_.exposure_of(shot->second.start, shot->second.end);
  Truth truth;
  if (taken != nullptr && shows_impact(*taken))
    truth.value = sim::true_readout(rig_.scene(), taken->ball->path);
  truth.images_ambiguous = taken != nullptr && images_are_ambiguous(lab_setup_.scene, *taken);
  const reduction::Readout& readout = shot_result.readout;
  checker_.readout(host_.process->id(), key, readout, truth, shot_result.dry);
  const bool numbers = has_numbers(readout);
  ++(numbers ? (shot_result.rejected ? counts_.flagged : counts_.good) : counts_.withheld);
  std::string flags;
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    if (!readout.flags.has(static_cast<reduction::Flag>(i))) continue;
    ++counts_.flags[i];
    flags.append(" ").append(reduction::kFlagNames[i]);
  }
  trace("readout of shot {}: {}{}", shot_result.shot_id, numbers ? "numbers" : "no numbers", flags);
  mix(static_cast<std::uint64_t>(shot_result.shot_id));
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto& value = readout.value[static_cast<reduction::Quantity>(i)];
    mix(value ? std::bit_cast<std::uint64_t>(*value) : 0);
  }
  const auto& comparison = checker_.last_comparison();
  if (!comparison) return;
  counts_.compared += comparison->compared;
  counts_.explained += comparison->explained;
  counts_.mismatched += comparison->mismatched;
  for (std::size_t f = 0; f < reduction::kFlagCount; ++f) counts_.explained_by[f] += comparison->by_flag[f];
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    bool explained = false;
    for (std::size_t f = 0; f < reduction::kFlagCount; ++f) {
      const auto flag = static_cast<reduction::Flag>(f);
      explained = explained || (readout.flags.has(flag) && explains(flag));
    }
    if (!explained && !(truth.images_ambiguous && comparison->z[i] > soak_sigma_limit()))
      counts_.largest_z[i] = std::max(counts_.largest_z[i], comparison->z[i]);
  }
}

// The run ----------------------------------------------------------------------------------------------

bool Lab::over() {
  const auto& violations = checker_.violations();
  for (; violations_traced_ < violations.size(); ++violations_traced_)
    trace("VIOLATION: {}", violations[violations_traced_]);
  if (time_ > from_ns(1'000'000'000'000) + kLongestRun) {
    checker_.violate("the run does not end");
    return true;
  }
  return finished_ && std::none_of(driven_.begin(), driven_.end(), [](bool driven) { return driven; });
}

/// Delivers what is still on its way; nothing new is sent.
void Lab::settle() {
  while (bus_.next_due() != kFarFuture) {
    const VirtualBus::Delivery delivery = bus_.take();
    if (delivery.to == Receiver::host) checker_.at_host(delivery.packet->channel, delivery.packet->bytes);
    bus_.done(delivery);
  }
}

void Lab::trace_lab_setup() {
  const sim::Scene& scene = lab_setup_.scene;
  const ShotPlan& even = lab_setup_.plan.even;
  const auto degrees = [](double rad) { return rad * 180.0 / std::numbers::pi; };
  trace(
      "scene: {:.2f} m/s at {:.1f} degrees, {:.0f} rad/s, e {:.2f}, mu {:.2f}, dwell {:.2f} ms, tilt {:.1f} "
      "degrees{}",
      scene.machine.speed_mps, degrees(scene.machine.angle_rad), scene.machine.spin_radps, scene.bounce.e,
      scene.bounce.mu, scene.bounce.dwell_s * 1e3, degrees(scene.surface_angle_rad),
      scene.camera.mirrored ? ", mirrored" : "");
  trace("plan: {} train, every {:.0f} us, {:.0f} ms; centres to {:.2f} mm, equators to {:.2f} degrees",
        even.train == Train::gated ? "gated" : "free", to_microseconds(even.period),
        1e3 * to_seconds(even.exposure), scene.tablet.centre_sd_m * 1e3,
        degrees(scene.tablet.equator_sd_rad));
}

SoakCounts Lab::run() {
  counts_.runs = 1;
  counts_.planned = settings_.shots;
  trace_lab_setup();
  boot();
  bool started = false;
  // Not before the firmware's first word on key and e-stop: it says that they are in the way until it has read them.
  command_due_ = true;
  in(milliseconds(100), Action::give_command);
  if (settings_.faults[Hazard::page_disarm] > 0.0) start_watcher();
  in(Duration{}, Action::draw_hazards);
  while (!over()) {
    if (!firmware_) {
      process_next();
      started = false;
      continue;
    }
    if (!started) {
      started = true;
      firmware_->loop().start("strobed, virtual");
    } else if (stop_asked_ && !dead_) {
      stop_firmware();
    } else if (!firmware_->loop().step(firmware::kNoDeadline) && !dead_) {
      die();
    }
    if (dead_) firmware_.reset();
  }
  settle();
  checker_.end(disk_.path());
  over();
  counts_.triggers = checker_.triggers();
  counts_.events_journalled = checker_.events_journalled();
  counts_.events_missing = checker_.events_missing();
  counts_.events_never_received = checker_.events_never_received();
  const InvariantChecker::Stops& stops = checker_.stops();
  counts_.stops_reached = stops.reached;
  counts_.stops_asked = stops.asked;
  counts_.stops_confirmed = stops.confirmed;
  counts_.stops_told_missing = stops.danger_shown;
  counts_.stopped_triggers = stops.triggers;
  counts_.violations = static_cast<std::int64_t>(checker_.violations().size());
  counts_.packets = bus_.counts().sent;
  counts_.packets_lost = bus_.counts().lost;
  counts_.packets_doubled = bus_.counts().doubled;
  counts_.packets_reordered = bus_.counts().reordered;
  counts_.virtual_s = to_seconds(time_ - from_ns(1'000'000'000'000));
  counts_.digest = digest_;
  return counts_;
}

}  // namespace strobe::soak
