// The rig around an emulated machine: the simulator's own model of lamps, sensors, shutter, machine and ball
// answers what the kernel's driver does to its lines, in a thread of its own; whoever digitizes is at the
// other end of LCM. Stamps are those of the emulated machine's clock, as well as they are known from outside:
// later than the truth, by up to a tenth of a second. One thread makes, asks and destroys it.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "sim/live/exposures.hpp"
#include "sim/live/tablet_operator.hpp"
#include "sim/rig/rig.hpp"
#include "tests/kernel/lcm_bridge.hpp"
#include "tests/kernel/virtual_machine.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::kernel {

/// Offsets of rig.toml here.
enum class Pin : unsigned { strobe_a, strobe_b, shutter, trigger, sensor_a, sensor_b, key, estop };
inline constexpr unsigned kOutputPins = 4;

struct LineEvent {
  Pin pin = Pin::strobe_a;
  int level = 0;
};

/// What tests/kernel/prepare made: of this build, or what $STROBE_KERNEL_BOOT names.
std::filesystem::path boot_folder();

class KernelFixture {
 public:
  /// What is done in the machine before the rig is there; returns the lab's key.
  using Install = std::function<std::string(VirtualMachine&)>;

  /// `boot` as VirtualMachine wants it; if there is a lab.key, or an `install` that makes one, that is the host's.
  explicit KernelFixture(const std::filesystem::path& boot, const Install& install = {});
  ~KernelFixture();

  VirtualMachine& machine() { return machine_; }
  const LcmBridge& bridge() const { return bridge_; }
  const std::filesystem::path& folder() const { return folder_.path(); }

  /// Starts the firmware there; true once it says that it is ready. `program`: strobed, or /gpiod2/strobed, which is made
  /// with libgpiod 2.
  bool start_strobed(const std::string& program = "strobed");
  std::string strobed_log();

  /// `strobe` of this build with those words, in this network and with this rig.
  testing::Command strobe(std::vector<std::string> words) const;

  /// All that happened on the lines so far, outputs and inputs, in order.
  std::vector<LineEvent> events() const;
  int rises(Pin pin) const;

  /// Drives an input by hand.
  void drive(Pin pin, int level);
  /// Drives it at the very moment of strobe A's nth rise from the start.
  void drive_at_flash(int flash, Pin pin, int level);
  std::size_t scheduled_drives() const;  ///< of these, not yet carried out

 private:
  struct ScheduledDrive {
    int at_flash = 0;  ///< 0: at once
    Pin pin = Pin::key;
    int level = 0;
  };

  void run();
  void take_change();
  void give_drives();
  void apply_scheduled_drives();
  void note(Pin pin, int level);
  void drive_pin(Pin pin, int level);
  MonoTime there() const;

  testing::TemporaryFolder folder_;
  LcmBridge bridge_;
  VirtualMachine machine_;
  Duration clock_offset_{};  ///< the machine's clock, against this one
  sim::ExposureStore exposure_store_;
  std::unique_ptr<sim::TruthFile> truth_;
  std::unique_ptr<sim::Rig> rig_;
  std::unique_ptr<sim::TabletOperator> tablet_operator_;
  mutable std::mutex mutex_;
  std::vector<LineEvent> events_;
  std::vector<ScheduledDrive> scheduled_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

/// Levels of the four outputs after all of these.
bool outputs_inactive(const std::vector<LineEvent>& events);

}  // namespace strobe::kernel
