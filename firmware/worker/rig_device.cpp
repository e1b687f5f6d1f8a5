#include "firmware/worker/rig_device.hpp"

#include <optional>
#include <random>
#include <thread>
#include <utility>

#include "firmware/core/timed_outputs.hpp"
#include "firmware/flash_sequencer/inputs.hpp"
#include "firmware/flash_sequencer/outputs.hpp"
#include "firmware/flash_sequencer/tty_line.hpp"
#include "firmware/linux/gpio_inputs.hpp"
#include "firmware/linux/gpio_outputs.hpp"
#include "firmware/linux/rig_lines.hpp"
#include "firmware/linux/system_clock.hpp"
#include "firmware/rp1_pio/dev_pio.hpp"
#include "firmware/rp1_pio/local_sequencer.hpp"

namespace strobe::firmware {

namespace {

/// Tells the guardian before an output can become active, in whichever turn that is.
class ToldOutputs final : public OutputLines {
 public:
  ToldOutputs(GpioOutputs& outputs, SharedStatus& page) : outputs_(outputs), page_(page) {}
  bool set(Output output, bool active) noexcept override {
    if (active) page_.shot_under_way = true;
    return outputs_.set(output, active);
  }
  bool set_lamps(Lamps lamps) noexcept override {
    page_.shot_under_way = true;
    return outputs_.set_lamps(lamps);
  }

 private:
  GpioOutputs& outputs_;
  SharedStatus& page_;
};

class ChipDevice final : public RigDevice {
 public:
  ChipDevice(const Rig& rig, GpioOutputs lines) : rig_(rig), lines_(std::move(lines)) {}

  bool make_inactive() noexcept override { return lines_.make_inactive(); }
  void release() noexcept override { lines_.release(); }
  Result<DevicePorts> open_ports(Clock& clock, SharedStatus& page, int wake) override {
    auto inputs = GpioInputs::open(rig_, wake);
    if (!inputs) return tl::unexpected(inputs.error());
    inputs_ = std::move(*inputs);
    outputs_.emplace(rig_, clock, told_.emplace(lines_, page));
    return DevicePorts{*inputs_, *outputs_, inputs_->warnings()};
  }

 private:
  const Rig& rig_;
  GpioOutputs lines_;
  std::unique_ptr<GpioInputs> inputs_;
  std::optional<ToldOutputs> told_;
  std::optional<TimedOutputs> outputs_;
};

/// It cuts its outputs by itself when this process's beats stop.
class SequencerDevice final : public RigDevice {
 public:
  SequencerDevice(const Rig& rig, std::unique_ptr<TtyLine> line) : rig_(rig), line_(std::move(line)) {}

  bool make_inactive() noexcept override { return send_abort(*line_); }
  bool confirms() const noexcept override { return false; }
  void release() noexcept override {
    if (heartbeat_) heartbeat_->stop();
    line_->release();
  }
  Result<DevicePorts> open_ports(Clock& clock, SharedStatus& page, int wake) override {
    heartbeat_.emplace(*line_, clock);
    link_.emplace(*line_, *heartbeat_, clock);
    if (auto done = link_->connect(kPatience); !done) return line_failure_of(rig_, done.error());
    line_->set_wake(wake);
    if (!rig_.chip.empty()) {
      auto kernel = GpioInputs::open(witnessed_lines(rig_), kNoWake);
      if (!kernel) return tl::unexpected(kernel.error());
      kernel_ = std::move(*kernel);
      witness_.emplace(*kernel_, *link_);
    }
    heartbeat_->start(page.loop_heartbeat_ns, rig_.real_time.priority + 1, rig_.real_time.cpu);
    Witness* witness = witness_ ? &*witness_ : nullptr;
    return DevicePorts{
        inputs_.emplace(rig_, *link_, clock, witness), outputs_.emplace(rig_, *link_, clock), {}};
  }

  static constexpr Duration kPatience = milliseconds(2000);
  static tl::unexpected<Error> line_failure_of(const Rig& rig, const Error& error) {
    return fail(place(rig, rig.flash_sequencer.port_file_line, "sequencer.port") + error.message);
  }

 private:
  const Rig& rig_;
  std::unique_ptr<TtyLine> line_;
  std::optional<Heartbeat> heartbeat_;
  std::optional<FlashSequencerLink> link_;
  static constexpr int kNoWake = -1;  // the sequencer's line wakes the loop
  std::unique_ptr<GpioInputs> kernel_;
  std::optional<Witness> witness_;
  std::optional<FlashSequencerInputs> inputs_;
  std::optional<FlashSequencerOutputs> outputs_;
};

/// Of a rig file that was checked.
Rp1Pins pins_of(const Rig& rig) {
  const auto pin = [&rig](Line which) {
    const LineConfig& line = rig.line(which);
    return line.fitted ? static_cast<unsigned>(line.offset) : Rp1Pins::kNotFitted;
  };
  Rp1Pins pins;
  pins.outputs.fill(Rp1Pins::kNotFitted);
  for (const auto& [output, line] : {std::pair{flash_sequencer::OutputLine::shutter, Line::shutter},
                                     {flash_sequencer::OutputLine::trigger, Line::trigger},
                                     {flash_sequencer::OutputLine::strobe_a, Line::strobe_a},
                                     {flash_sequencer::OutputLine::strobe_b, Line::strobe_b}})
    pins.outputs.at(static_cast<std::size_t>(output)) = pin(line);
  pins.key = pin(Line::key);
  pins.estop = pin(Line::estop);
  pins.gate = pin(Line::gate);
  pins.gate_active_low = rig.line(Line::gate).active_low;
  return pins;
}

std::uint64_t drawn_number() {
  std::random_device device;
  return std::uniform_int_distribution<std::uint64_t>()(device);
}

class PioOutputs final : public FlashSequencerOutputs {
 public:
  PioOutputs(const Rig& rig, FlashSequencerLink& link, Clock& clock, const Rp1Hardware& hardware)
      : FlashSequencerOutputs(rig, link, clock), hardware_(hardware) {}
  ShortText clock_words() const noexcept override {
    const auto ppb = [](double drift) { return static_cast<std::int64_t>(drift * 1e9); };
    const Rp1Hardware::Clocks clocks = hardware_.clocks();
    return ShortText("issued by the PIO's clock, its start known to ")
        .append(clocks.start_within.count())
        .append(" ns, drift ")
        .append(ppb(clocks.drift))
        .append(" ppb, known to ")
        .append(ppb(clocks.drift_sd))
        .append(" ppb; sensors and gate stamped by the kernel");
  }

 private:
  const Rp1Hardware& hardware_;
};

/// The lines are taken as always; their pins are given to the PIO, which cuts them when this process's beats
/// stop, and can be taken back from it.
class PioDevice final : public RigDevice {
 public:
  PioDevice(const Rig& rig, GpioOutputs lines, std::unique_ptr<DevPio> block)
      : rig_(rig), lines_(std::move(lines)), block_(std::move(block)) {}

  bool make_inactive() noexcept override {
    // First what asks nothing of the board's firmware, for which others may wait.
    const bool taken_back = lines_.take_back();
    return firmware::cut_outputs(*block_) || taken_back;
  }
  void release() noexcept override {
    if (heartbeat_) heartbeat_->stop();
    if (sequencer_) sequencer_->stop();
    lines_.release();
    // Its threads would have to be waited for. The guardian's hold is the same one.
    if (!sequencer_) block_->release();
  }
  Result<DevicePorts> open_ports(Clock& clock, SharedStatus& page, int wake) override {
    LocalLine& line = line_.emplace(clock);
    auto kernel = GpioInputs::open(rig_, line.request_fd());
    if (!kernel) return tl::unexpected(kernel.error());
    kernel_ = std::move(*kernel);
    hardware_.emplace(*block_, *kernel_, clock, pins_of(rig_), drawn_number());
    const int priority = rig_.real_time.priority + 1;
    block_->start(priority);
    if (!hardware_->take()) return failure("\"" + rig_.pio.device + "\" does not do as it is told");
    sequencer_.emplace(*hardware_, line, clock, drawn_number()).start(priority);
    heartbeat_.emplace(line, clock);
    link_.emplace(line, *heartbeat_, clock);
    if (auto done = link_->connect(kPatience); !done) return failure(done.error().message);
    line.set_wake(wake);
    heartbeat_->start(page.loop_heartbeat_ns, priority, rig_.real_time.cpu);
    return DevicePorts{inputs_.emplace(rig_, *link_, clock),
                       outputs_.emplace(rig_, *link_, clock, *hardware_), kernel_->warnings()};
  }

 private:
  static constexpr Duration kPatience = milliseconds(2000);
  tl::unexpected<Error> failure(const std::string& what) const {
    return fail(place(rig_, rig_.pio.file_line, "chip.pio") + what);
  }

  const Rig& rig_;
  GpioOutputs lines_;
  std::unique_ptr<DevPio> block_;
  std::optional<LocalLine> line_;
  std::unique_ptr<GpioInputs> kernel_;
  std::optional<Rp1Hardware> hardware_;
  std::optional<LocalSequencer> sequencer_;
  std::optional<Heartbeat> heartbeat_;
  std::optional<FlashSequencerLink> link_;
  std::optional<FlashSequencerInputs> inputs_;
  std::optional<PioOutputs> outputs_;
};

/// Of an open line that no heartbeat's thread writes to.
Result<void> cut_outputs(const Rig& rig, TtyLine& line, Duration patience) {
  SystemClock clock;
  Heartbeat heartbeat(line, clock);
  const auto cut = FlashSequencerLink(line, heartbeat, clock).make_inactive(patience);
  if (cut) return cut;
  return SequencerDevice::line_failure_of(
      rig, {cut.error().message + "; one that works cuts its outputs by itself when the beats stop"});
}

/// A strobed that is being killed may hold the line for some milliseconds yet.
Result<void> cut_outputs_anew(const Rig& rig, Duration patience) {
  constexpr Duration kAgain = milliseconds(2);
  SystemClock clock;
  const MonoTime end = clock.now() + patience;
  auto line = TtyLine::open(rig);
  while (!line && clock.now() < end) {
    std::this_thread::sleep_for(kAgain);
    line = TtyLine::open(rig);
  }
  return line ? cut_outputs(rig, **line, patience) : Result<void>(tl::unexpected(line.error()));
}

}  // namespace

Result<std::unique_ptr<RigDevice>> RigDevice::open(const Rig& rig) {
  if (rig.flash_sequencer.fitted()) {
    auto line = TtyLine::open(rig);
    if (!line) return tl::unexpected(line.error());
    if (auto cut = cut_outputs(rig, **line, SequencerDevice::kPatience); !cut)
      return tl::unexpected(cut.error());
    return std::make_unique<SequencerDevice>(rig, std::move(*line));
  }
  auto lines = GpioOutputs::open(rig);
  if (!lines) return tl::unexpected(lines.error());
  if (!rig.pio.fitted()) return std::make_unique<ChipDevice>(rig, std::move(*lines));
  auto block = DevPio::open(rig);
  if (!block) return tl::unexpected(block.error());
  return std::make_unique<PioDevice>(rig, std::move(*lines), std::move(*block));
}

Result<Takeover> prepare_takeover(const Rig& rig) {
  if (rig.flash_sequencer.fitted())
    return [&rig](Duration patience) { return cut_outputs_anew(rig, patience); };
  auto prepared = OutputTakeover::prepare(rig);
  if (!prepared) return tl::unexpected(prepared.error());
  const auto shared = std::make_shared<OutputTakeover>(std::move(*prepared));
  return [shared](Duration patience) { return shared->drive_inactive(patience); };
}

}  // namespace strobe::firmware
