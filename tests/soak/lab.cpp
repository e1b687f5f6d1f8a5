// The lab's clock, its rig and the ports of the firmware's loop.
#include "tests/soak/lab.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "firmware/core/rig.hpp"

#include "tests/soak/lab_parts.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::soak {

using firmware::Input;
using firmware::Output;

namespace {

// Durations of the loop's own calls.
constexpr Duration kClockReading = nanoseconds(20);
constexpr Duration kSpinsEnd = nanoseconds(30);
constexpr Duration kHalfASet = nanoseconds(150);
constexpr Duration kWakeUp = microseconds(3);
constexpr Duration kPoll = kWakeUp + nanoseconds(120);  // from one look at the inputs to the next
constexpr std::size_t kKernelBuffer = 16;

constexpr std::size_t index(Input input) { return static_cast<std::size_t>(input); }

std::uint64_t seed_of(const RunSettings& settings) {
  return mixed(settings.seed, static_cast<std::uint64_t>(settings.run) + 1);
}

LabSetup lab_setup_of(const RunSettings& settings, const host::PlanFile& shipped, Random& random) {
  LabSetup lab_setup = draw_lab_setup(settings.plan, shipped, random);
  // Rejected shots are fired again; a run never has more exposures than this.
  lab_setup.scene.faults = draw_rig_faults(settings.faults, 4 * settings.shots + 20, random);
  return lab_setup;
}

HostSettings host_settings_of(const RigFiles& files, const RunSettings& settings, const LabSetup& lab_setup) {
  HostSettings host;
  host.rig = files.host.rig;
  host.assembly = host::assembly_settings(files.host);
  const bool mirrored = lab_setup.scene.camera.mirrored;
  host.assembly.analysis.surface_angle_deg =
      lab_setup.scene.surface_angle_rad * (mirrored ? -1.0 : 1.0) * 180.0 / std::numbers::pi;
  host::ShotSeriesSettings& series = host.series.emplace();
  series.shots = settings.shots;
  series.retries = 2 * settings.shots;
  series.plan = lab_setup.plan.shot();
  series.notes = lab_setup.notes;
  series.clear_fault = true;
  series.photograph_timeout_s = host.assembly.analysis.photograph_timeout_s;
  return host;
}

}  // namespace

Result<RigFiles> read_rig_files(const std::string& path) {
  const std::string text = testing::read_text(path);
  auto rig = firmware::read_rig(text, path);
  if (!rig) return tl::unexpected(rig.error());
  auto host = host::read_rig(text, path);
  if (!host) return tl::unexpected(host.error());
  return RigFiles{std::move(*rig), std::move(*host)};
}

Lab::Lab(const RigFiles& files, const RunSettings& settings)
    : files_(files),
      settings_(settings),
      random_(seed_of(settings)),
      lab_setup_(lab_setup_of(settings, files.host.plan, random_)),
      host_settings_(host_settings_of(files, settings, lab_setup_)),
      time_(from_ns(1'000'000'000'000)),
      bus_(random_.bits()),
      rig_(lab_setup_.scene, random_.bits() >> 1, time_),
      tablet_operator_(lab_setup_.scene, rig_.seed()),
      checker_(files.firmware),
      stranger_(mixed(seed_of(settings), 3), files.host.rig, lab_key_),
      strangers_bus_(mixed(seed_of(settings), 4)),
      publisher_clock_(std::make_unique<PublisherClock>(*this)),
      publisher_wake_(std::make_unique<PublisherWake>(*this)),
      loop_wake_(std::make_unique<LoopWake>(*this)),
      host_(Receiver::host, random_),
      other_host_(Receiver::other_host, random_),
      watcher_(Receiver::watcher, random_) {
  bus_.set_faults(
      {settings.faults.packet_loss, settings.faults.packet_duplication, settings.faults.packet_reordering});
  strangers_bus_.set_faults({0.0, 0.1, 0.5});
  publisher_latency_ = nanoseconds(std::llround(random_.log_uniform(0.5e6, 30e6)));
}

Lab::~Lab() = default;

// Time ------------------------------------------------------------------------------------------------------

MonoTime Lab::next() {
  if (schedule_changed_) {
    next_ = std::min({timeline_.next(), bus_.next_due(), strangers_bus_.next_due(), rig_.next_due(),
                      tablet_operator_.next_due(), publisher_due_, hosts_due()});
    schedule_changed_ = false;
  }
  return next_;
}

void Lab::process_next() {
  const MonoTime at = next();
  schedule_changed_ = true;
  time_ = std::max(time_, at);
  if (rig_.next_due() <= at) return collect_rig();
  if (bus_.next_due() <= at) return deliver();
  if (strangers_bus_.next_due() <= at) return deliver_strangers();
  if (publisher_due_ <= at) return publisher_turn();
  if (hosts_due() <= at) return host_turn();
  if (tablet_operator_.next_due() <= at) return tablet_operator_turn();
  perform(timeline_.take().item);
}

void Lab::advance_to(MonoTime instant) {
  while (next() <= instant) {
    process_next();
    if (dead_ && firmware_) return;
  }
  time_ = std::max(time_, instant);
}

void Lab::pass(Duration duration) {
  if (dead_) return;
  advance_to(time_ + duration);
  while (!dead_ && time_ < still_until_) advance_to(still_until_);
}

// Ports of the loop -----------------------------------------------------------------------------------------

MonoTime Lab::now() noexcept {
  pass(kClockReading);
  return time_;
}

MonoTime Lab::spin_until(MonoTime instant) noexcept {
  if (dead_) return std::max(time_, instant);
  if (instant > time_) pass(instant - time_);
  pass(kSpinsEnd);
  return std::max(time_, instant);  // time stands still for a process that dies meanwhile
}

bool Lab::set(Output output, bool active) noexcept {
  count_down_call_hazards();
  pass(kHalfASet);
  if (dead_) return true;
  drive(output, active);
  pass(kHalfASet);
  return true;
}

bool Lab::set_lamps(strobe::Lamps lamps) noexcept {
  count_down_call_hazards();
  pass(kHalfASet);
  if (dead_) return true;
  drive(Output::strobes, true, lamps);
  pass(kHalfASet);
  return true;
}

std::optional<std::size_t> Lab::wait(MonoTime until, std::span<firmware::Edge> edges) noexcept {
  while (!dead_ && !woken_ && waiting_edges_ == 0) {
    if (next() > until) {
      time_ = std::max(time_, until);
      break;
    }
    process_next();
  }
  woken_ = false;
  pass(kWakeUp);
  return dead_ ? 0 : drain(edges);
}

std::optional<std::size_t> Lab::poll(MonoTime until, std::span<firmware::Edge> edges) noexcept {
  pass(kWakeUp);
  while (!dead_ && !woken_ && waiting_edges_ == 0 && time_ < until) {
    // Looks that find nothing are skipped, up to the one that follows the next scheduled item.
    const std::int64_t looks = (std::min(next(), until) - time_ + kPoll - nanoseconds(1)) / kPoll;
    pass(std::max<std::int64_t>(1, looks) * kPoll);
  }
  woken_ = false;
  return dead_ ? 0 : drain(edges);
}

std::size_t Lab::drain(std::span<firmware::Edge> edges) {
  if (waiting_edges_ == 0) return 0;
  std::size_t count = 0;
  for (auto& buffer : kernel_) {
    if (buffer.size() == kKernelBuffer) ++overflows_;
    for (; !buffer.empty() && count < edges.size(); --waiting_edges_) {
      edges[count++] = buffer.front();
      buffer.pop_front();
    }
  }
  std::sort(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(count),
            [](const firmware::Edge& a, const firmware::Edge& b) { return a.time < b.time; });
  return count;
}

std::optional<bool> Lab::level(Input input) noexcept {
  return input == Input::key ? key_ : input == Input::estop ? estop_ : false;
}

void Lab::publish(const std::string& channel, std::span<const std::uint8_t> bytes) {
  send_to_host(channel, bytes);
  if (!channel.ends_with("/SHOT")) return;
  bus_.send(Receiver::tablet, channel, bytes, time_);
  note_shot(bytes);
}

// Rig -----------------------------------------------------------------------------------------------------

void Lab::drive(Output output, bool active, strobe::Lamps lamps) {
  bool& driven = driven_[index_of(output)];
  if (driven == active) return;
  driven = active;
  schedule_changed_ = true;
  mix(static_cast<std::uint64_t>(to_ns(time_)) ^ (index_of(output) << 1) ^ (active ? 1 : 0));
  trace("{} {}",
        output == Output::trigger   ? "TRIGGER"
        : output == Output::strobes ? "lamps"
                                    : "shutter",
        active ? "on" : "off");
  checker_.output(output, active, time_, lamps);
  const int level = active ? 1 : 0;
  switch (output) {
    case Output::trigger:
      return rig_.line_changed(sim::RigLine::trigger, level, time_);
    case Output::shutter:
      return rig_.line_changed(sim::RigLine::shutter, level, time_);
    case Output::strobes:
      if (!active || has_a(lamps)) rig_.line_changed(sim::RigLine::strobe_a, level, time_);
      if (!active || has_b(lamps)) rig_.line_changed(sim::RigLine::strobe_b, level, time_);
      return;
  }
}

void Lab::edge(Input input, bool active, MonoTime at) {
  if (dead_) return;  // nobody has requested the line
  auto& buffer = kernel_[index(input)];
  if (buffer.size() == kKernelBuffer) return;  // the newest are lost
  buffer.push_back({input, at, active});
  ++waiting_edges_;
}

void Lab::set_key(bool on) {
  if (key_ == on) return;
  key_ = on;
  trace("key {}", on ? "on" : "off");
  checker_.key(on, time_);
  edge(Input::key, on, time_);
}

void Lab::set_estop(bool pressed) {
  if (estop_ == pressed) return;
  estop_ = pressed;
  trace("e-stop {}", pressed ? "pressed" : "released");
  checker_.estop(pressed, time_);
  edge(Input::estop, pressed, time_);
}

void Lab::collect_rig() {
  drives_.clear();
  exposures_.clear();
  rig_.collect(time_, drives_, exposures_);
  for (const sim::Drive& drive : drives_) {
    if (drive.level == 0) continue;  // sensors and gate report their active edges only
    if (drive.line == sim::RigLine::sensor_a) edge(Input::sensor_a, true, drive.at);
    if (drive.line == sim::RigLine::sensor_b) edge(Input::sensor_b, true, drive.at);
    if (drive.line == sim::RigLine::gate) edge(Input::gate, true, drive.at);
  }
  for (sim::Exposure& exposure : exposures_) {
    for (const sim::FaultKind kind : exposure.faults) ++counts_.rig_faults[static_cast<std::size_t>(kind)];
    for (const auto kind :
         {sim::FaultKind::no_photograph, sim::FaultKind::frame_late, sim::FaultKind::image_unseen})
      if (shot_fault(lab_setup_.scene.faults, kind, exposure.shot))
        ++counts_.rig_faults[static_cast<std::size_t>(kind)];
    if (settings_.trace != nullptr) {
      std::string faults;
      for (const sim::FaultKind kind : exposure.faults) faults.append(" ").append(name(kind));
      trace("exposure {} of {} pulses{}{}", exposure.shot, exposure.pulses.size(),
            shows_impact(exposure) ? "" : " without a ball", faults);
    }
    tablet_operator_.add(std::move(exposure));
  }
}

}  // namespace strobe::soak
