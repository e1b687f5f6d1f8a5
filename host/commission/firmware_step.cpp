#include <fmt/format.h>

#include "host/commission/steps.hpp"

namespace strobe::commission {
namespace {

using strobe_msgs::status_t;

constexpr int kHeartbeats = 4;
constexpr Duration kFirmwarePatience = std::chrono::seconds{20};

StepResult unheard(const Situation& situation) {
  if (situation.other_key > 0)
    return failed("other_key",
                  "a firmware is heard here that has another key than this host, and is not believed",
                  "compare the fingerprints that `strobe key` and strobed tell, and copy the lab's key");
  return failed("not_heard", "no firmware was heard within 20 s",
                "is strobed running, with the same rig name, LCM URL and network? `strobed --check` says "
                "what it lacks");
}

/// Absent: nothing is wrong.
std::optional<StepResult> trouble(const Situation& situation, const status_t& status) {
  if (!situation.danger.empty())
    return failed("outputs_active", situation.danger,
                  "switch lamps and machine off by hand, then start strobed anew");
  if (!status.journal_ok)
    return failed("journal", "the firmware's journal cannot be written",
                  "look at the disk of strobed's --session folder: full, read-only, gone?");
  if (status.state == status_t::FAULT)
    return failed("fault_latched", "the firmware has latched a fault: " + status.message,
                  "mend what it names, then `strobe fire --dry --clear-fault`");
  if (status.queue_overflows > 0)
    return failed("events_lost",
                  fmt::format("{} events were lost between the loop and the journal", status.queue_overflows),
                  "the disk of strobed's --session folder is too slow: take another one");
  return std::nullopt;
}

class FirmwareStep final : public Step {
 public:
  FirmwareStep()
      : Step({{"firmware", "firmware, chip and lines", {"chip", "lines", "real_time", "commands"}}}, {}) {}
  std::string briefing(const host::RigFile& rig) const override;
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;

 private:
  HostTime begun_;
  std::int64_t last_mono_ns_ = 0;
  int heartbeats_ = 0;
};

std::string FirmwareStep::briefing(const host::RigFile& rig) const {
  return fmt::format(
      "Listens to the firmware of rig {} for two seconds. Nothing moves. (`strobed --check`, on the rig's "
      "computer, tries chip, lines and real time before.)",
      rig.rig);
}

void FirmwareStep::begin(const Situation& situation) {
  begun_ = situation.now;
  last_mono_ns_ = 0;
  heartbeats_ = 0;
}

Request FirmwareStep::step(const Situation& situation) {
  if (!situation.status) {
    if (situation.now - begun_ > kFirmwarePatience) return Done{{unheard(situation)}};
    return Wait{"waiting for the firmware"};
  }
  const status_t& status = *situation.status;
  if (auto found = trouble(situation, status)) return Done{{std::move(*found)}};
  if (status.mono_ns != last_mono_ns_) ++heartbeats_;
  last_mono_ns_ = status.mono_ns;
  if (heartbeats_ < kHeartbeats) return Wait{"listening"};
  StepResult result = passed(static_cast<double>(status.queue_overflows + status.kernel_overflows), {},
                             "events lost", "none lost to the journal");
  result.words = fmt::format("the firmware is heard{}, its journal is written, {}",
                             situation.verified ? ", and is this lab's" : "",
                             status.real_time ? "its real-time rights are granted"
                                              : "real-time rights are ABSENT, which --allow-no-rt allows");
  if (!status.real_time)
    result.advice =
        "flashes may come late: see what `strobed --check` says of them, and start it without "
        "--allow-no-rt";
  result.figures = {{"real_time", status.real_time ? 1.0 : 0.0, {}, 1.0, 0},
                    {"kernel_overflows", static_cast<double>(status.kernel_overflows), {}, 0.0, 0},
                    {"queue_overflows", static_cast<double>(status.queue_overflows), {}, 0.0, 0}};
  return Done{{std::move(result)}};
}

}  // namespace

std::unique_ptr<Step> firmware_step() { return std::make_unique<FirmwareStep>(); }

std::vector<std::unique_ptr<Step>> all_steps() {
  std::vector<std::unique_ptr<Step>> steps;
  for (auto* const add : {firmware_step, key_step, key_wire_step, estop_step, estop_wire_step})
    steps.push_back(add());
  for (const Lamps lamp : {Lamps::a, Lamps::b}) steps.push_back(lamp_step(lamp));
  for (auto* const add :
       {lamps_together_step, shutter_step, light_step, board_step, drop_step, trigger_step, ball_step})
    steps.push_back(add());
  return steps;
}

std::vector<StepInfo> all_infos() {
  std::vector<StepInfo> infos;
  for (const auto& step : all_steps()) infos.insert(infos.end(), step->infos().begin(), step->infos().end());
  return infos;
}

}  // namespace strobe::commission
