#include "tests/kernel/kernel_fixture.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <stdexcept>

#include "common/authentication/key_file.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/loading/load_scene.hpp"

namespace strobe::kernel {

namespace {

using sim::RigLine;

const Multicast kLcm{"239.255.76.67", 7667};
constexpr const char* kLcmUrl = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";
constexpr std::chrono::milliseconds kLongestWait{2};  // how soon orders are carried out
constexpr const char* kKey = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef";
constexpr Duration kLaterThanTrue = milliseconds(50);

constexpr std::array<std::pair<Pin, RigLine>, kPins> kWiring{{{Pin::strobe_a, RigLine::strobe_a},
                                                              {Pin::strobe_b, RigLine::strobe_b},
                                                              {Pin::shutter, RigLine::shutter},
                                                              {Pin::trigger, RigLine::trigger},
                                                              {Pin::sensor_a, RigLine::sensor_a},
                                                              {Pin::sensor_b, RigLine::sensor_b},
                                                              {Pin::key, RigLine::key},
                                                              {Pin::estop, RigLine::estop}}};

RigLine line_at(Pin pin) { return kWiring[static_cast<std::size_t>(pin)].second; }
std::optional<Pin> pin_of(RigLine line) {
  for (const auto& [pin, wired] : kWiring)
    if (wired == line) return pin;
  return std::nullopt;
}

/// How far the machine's CLOCK_MONOTONIC is behind this one's: its uptime, in hundredths of a second.
Duration clock_offset(VirtualMachine& machine) {
  const double uptime_s = std::stod(machine.run("cat /proc/uptime"));
  return sim::RigClock{}.now() - from_ns(static_cast<std::int64_t>(uptime_s * 1e9)) - kLaterThanTrue;
}

}  // namespace

std::filesystem::path boot_folder() {
  const char* named = std::getenv("STROBE_KERNEL_BOOT");
  return named != nullptr ? named : STROBE_BUILD_DIR "/kernel";
}

KernelFixture::KernelFixture(const std::filesystem::path& boot, const Install& install)
    : bridge_(kLcm, VirtualMachine::cable_here(folder_.path()), VirtualMachine::cable_there(folder_.path())),
      machine_(boot, folder_.path()),
      clock_offset_(clock_offset(machine_)) {
  const std::filesystem::path key = folder_.path() / "lab.key";
  const bool has_key = std::filesystem::exists(boot / "lab.key");
  testing::write_text(key, install   ? install(machine_)
                           : has_key ? testing::read_text(boot / "lab.key")
                                     : kKey);
  std::filesystem::permissions(key, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  const auto scene = sim::load_scene(STROBE_SOURCE_DIR "/tests/kernel/scene.toml");
  if (!scene) throw std::runtime_error(scene.error().message);
  auto truth = sim::TruthFile::create(folder_.path() / "truth.jsonl", *scene);
  if (!truth) throw std::runtime_error(truth.error().message);
  truth_ = std::move(*truth);
  rig_ = std::make_unique<sim::Rig>(*scene, 1, there());
  auto desk = sim::TabletOperator::create(kLcmUrl, "emulated", authentication::read_key_file(key).value(),
                                          *scene, 1, exposure_store_, *truth_);
  if (!desk) throw std::runtime_error(desk.error().message);
  tablet_operator_ = std::move(*desk);
  tablet_operator_->start();
  for (const Pin pin : {Pin::sensor_a, Pin::sensor_b}) machine_.drive(static_cast<unsigned>(pin), 0);
  for (const Pin pin : {Pin::key, Pin::estop}) machine_.drive(static_cast<unsigned>(pin), 1);
  thread_ = std::thread([this] { run(); });
}

KernelFixture::~KernelFixture() {
  stopping_ = true;
  thread_.join();
  tablet_operator_->stop();
}

MonoTime KernelFixture::there() const { return sim::RigClock{}.now() - clock_offset_; }

bool KernelFixture::start_strobed(const std::string& program) {
  // The same key on both sides.
  machine_.run("umask 077; echo " + std::string(kKey) + " >/tmp/lab.key");
  machine_.run("STROBE_KEY_FILE=/tmp/lab.key " + program +
               " --config /rig.toml --session /session 2>/tmp/strobed.log & echo $! >/tmp/pid");
  return testing::wait_until(
             [this] {
               const std::string log = strobed_log();
               return log.find("strobed: ready") != log.npos || machine_.run("pidof strobed").empty();
             },
             kTimeout) &&
         strobed_log().find("strobed: ready") != std::string::npos;
}

std::string KernelFixture::strobed_log() { return machine_.run("cat /tmp/strobed.log"); }

testing::Command KernelFixture::strobe(std::vector<std::string> words) const {
  words.insert(words.begin(), std::string(STROBE_BUILD_DIR) + "/bin/strobe");
  words.insert(words.end(), {"--rig", STROBE_SOURCE_DIR "/tests/kernel/rig.toml", "--lcm-url", kLcmUrl});
  testing::Command command;
  command.arguments = std::move(words);
  command.environment = {{"STROBE_KEY_FILE", (folder_.path() / "lab.key").string()}};
  return command;
}

std::vector<LineEvent> KernelFixture::events() const {
  const std::lock_guard lock(mutex_);
  return events_;
}

int KernelFixture::rises(Pin pin) const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(std::count_if(events_.begin(), events_.end(), [pin](const LineEvent& event) {
    return event.pin == pin && event.level == 1;
  }));
}

void KernelFixture::drive(Pin pin, int level) { drive_at_flash(0, pin, level); }

void KernelFixture::drive_at_flash(int flash, Pin pin, int level) {
  const std::lock_guard lock(mutex_);
  scheduled_.push_back({flash, pin, level});
}

std::size_t KernelFixture::scheduled_drives() const {
  const std::lock_guard lock(mutex_);
  return scheduled_.size();
}

void KernelFixture::note(Pin pin, int level) {
  const std::lock_guard lock(mutex_);
  events_.push_back({pin, level});
}

void KernelFixture::drive_pin(Pin pin, int level) {
  note(pin, level);
  machine_.drive(static_cast<unsigned>(pin), level);
}

void KernelFixture::apply_scheduled_drives() {
  std::vector<ScheduledDrive> due;
  const int flashes = rises(Pin::strobe_a);
  {
    const std::lock_guard lock(mutex_);
    const auto later =
        std::stable_partition(scheduled_.begin(), scheduled_.end(),
                              [&](const ScheduledDrive& order) { return order.at_flash <= flashes; });
    due.assign(scheduled_.begin(), later);
  }
  for (const ScheduledDrive& order : due) drive_pin(order.pin, order.level);
  const std::lock_guard lock(mutex_);
  scheduled_.erase(scheduled_.begin(), scheduled_.begin() + static_cast<std::ptrdiff_t>(due.size()));
}

void KernelFixture::take_change() {
  const Duration until_due = rig_->next_due() - there();
  const auto wait = std::clamp(std::chrono::milliseconds(until_due / milliseconds(1)),
                               std::chrono::milliseconds(0), kLongestWait);
  const auto change = machine_.next_change(wait);
  if (!change || change->pin >= kOutputPins) return;
  const auto pin = static_cast<Pin>(change->pin);
  note(pin, change->level);
  rig_->line_changed(line_at(pin), change->level, there());
}

void KernelFixture::give_drives() {
  std::vector<sim::Drive> drives;
  std::vector<sim::Exposure> exposures;
  rig_->collect(there(), drives, exposures);
  for (const sim::Drive& drive : drives)
    if (const auto pin = pin_of(drive.line)) drive_pin(*pin, drive.level);
  for (sim::Exposure& exposure : exposures) exposure_store_.add(std::move(exposure));
  exposure_store_.set_exposing(rig_->exposing_since());
}

void KernelFixture::run() {
  try {
    while (!stopping_) {
      take_change();
      apply_scheduled_drives();
      give_drives();
    }
  } catch (const std::runtime_error&) {
    // The machine is gone: whoever waits for its lines will see none.
  }
}

bool outputs_inactive(const std::vector<LineEvent>& events) {
  std::array<int, kOutputPins> levels{};
  for (const LineEvent& event : events)
    if (static_cast<unsigned>(event.pin) < kOutputPins)
      levels[static_cast<std::size_t>(event.pin)] = event.level;
  return std::all_of(levels.begin(), levels.end(), [](int level) { return level == 0; });
}

}  // namespace strobe::kernel
