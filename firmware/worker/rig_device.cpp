#include "firmware/worker/rig_device.hpp"

#include <optional>
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
  return std::make_unique<ChipDevice>(rig, std::move(*lines));
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
