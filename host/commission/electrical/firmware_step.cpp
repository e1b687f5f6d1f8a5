#include "host/commission/electrical/firmware_step.hpp"

#include <fmt/format.h>

namespace strobe::commission {
namespace {

using strobe_msgs::status_t;

constexpr int kHeartbeats = 4;
constexpr Duration kFirmwarePatience = std::chrono::seconds{20};
constexpr const char* kFirmwareId = "firmware";

StepResult unheard(const Situation& situation) {
  if (situation.other_key > 0)
    return failed(kFirmwareId, "other_key",
                  "a firmware is heard here that has another key than this host, and is not believed",
                  "compare the fingerprints that `strobe key` and strobed tell, and copy the lab's key");
  return failed(kFirmwareId, "not_heard", "no firmware was heard within 20 s",
                "is strobed running, with the same rig name, LCM URL and network? `strobed --check` says "
                "what it lacks");
}

/// Absent: nothing is wrong.
std::optional<StepResult> trouble(const Situation& situation, const status_t& status) {
  if (!situation.danger.empty())
    return failed(kFirmwareId, "outputs_active", situation.danger,
                  "switch lamps and machine off by hand, then start strobed anew");
  if (!status.journal_ok)
    return failed(kFirmwareId, "journal", "the firmware's journal cannot be written",
                  "look at the disk of strobed's --session folder: full, read-only, gone?");
  if (status.state == status_t::FAULT)
    return failed(kFirmwareId, "fault_latched", "the firmware has latched a fault: " + status.message,
                  "mend what it names, then `strobe fire --dry --clear-fault`");
  if (status.queue_overflows > 0)
    return failed(kFirmwareId, "events_lost",
                  fmt::format("{} events were lost between the loop and the journal", status.queue_overflows),
                  "the disk of strobed's --session folder is too slow: take another one");
  return std::nullopt;
}

}  // namespace

const std::vector<StepInfo>& FirmwareStep::infos() const {
  static const std::vector<StepInfo> infos{
      {kFirmwareId, "firmware, chip and lines", {"chip", "lines", "real_time", "commands"}}};
  return infos;
}

std::string FirmwareStep::briefing(const host::RigFile& rig) const {
  return fmt::format(
      "Listens to the firmware of rig {} for two seconds. Nothing moves. (`strobed --check`, on the rig's "
      "machine, tries chip, lines and real time before.)",
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
  StepResult result;
  result.id = kFirmwareId;
  result.state = StepState::passed;
  result.value = static_cast<double>(status.queue_overflows + status.kernel_overflows);
  result.unit = "events lost";
  result.limit = "none lost to the journal";
  result.words =
      fmt::format("the firmware is heard{}, its journal is written, real-time rights {}",
                  situation.verified ? ", and is this lab's" : "",
                  status.real_time ? "as wanted" : "not granted, which strobed was told to accept");
  result.figures = {{"real_time", status.real_time ? 1.0 : 0.0, {}, 1.0, 0},
                    {"kernel_overflows", static_cast<double>(status.kernel_overflows), {}, 0.0, 0},
                    {"queue_overflows", static_cast<double>(status.queue_overflows), {}, 0.0, 0}};
  return Done{{std::move(result)}};
}

}  // namespace strobe::commission
