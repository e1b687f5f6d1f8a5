#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/commission/shot_step.hpp"
#include "host/commission/steps.hpp"

namespace strobe::commission {
namespace {

using strobe_msgs::event_t;

constexpr int kTriggerFlashes = 50;  // of the exposure's length; one is fired
/// The loop's own lateness; a pulse that the line held longer is another thing.
constexpr double kPulseTolerance_ms = 2.0;

class TriggerStep final : public Step {
 public:
  TriggerStep()
      : Step({{"trigger", "the machine's trigger, without a ball", {"chip", "lines", "machine"}}},
             {.operator_acts = true, .outputs = true, .machine = true}) {}
  std::string briefing(const host::RigFile& rig) const override;
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;
  void on_event(const strobe_msgs::event_t& event, HostTime now) override;
  void on_shot(host::Shot shot) override;
  void on_no_shot(const std::string& why) override { problem_ = why; }
  void on_answer(bool yes) override { heard_ = yes; }

 private:
  StepResult judge(const Situation& situation) const;
  int rises(const strobe_msgs::shot_t& shot) const;

  Fire fire_;
  std::optional<strobe_msgs::shot_t> shot_;
  int repeated_ = 0;
  std::string problem_;
  std::vector<strobe_msgs::event_t> pulses_;
  std::optional<bool> heard_;  ///< the click; absent: not asked yet
};

std::string TriggerStep::briefing(const host::RigFile&) const {
  return "THE MACHINE'S TRIGGER IS PULSED ONCE, lamps flash, the shutter opens. Take all balls out of the "
         "machine, clear the lane; then power the machine, key on, e-stop released. Listen: it must click "
         "once.";
}

void TriggerStep::begin(const Situation& situation) {
  fire_ = {};
  fire_.plan = dry_train(situation.rig, Lamps::both, kTriggerFlashes);
  fire_.plan.code.resize(1);
  fire_.plan.dry = false;
  fire_.words = "the machine's trigger, once";
  fire_.readout = false;
  shot_.reset();
  repeated_ = 0;
  problem_.clear();
  pulses_.clear();
  heard_.reset();
}

void TriggerStep::on_event(const event_t& event, HostTime) {
  if (event.kind == event_t::TRIGGER) pulses_.push_back(event);
}

int TriggerStep::rises(const strobe_msgs::shot_t& shot) const {
  return static_cast<int>(std::ranges::count_if(pulses_, [&](const event_t& event) {
    return event.boot_id == shot.boot_id && event.shot_id == shot.shot_id && event.level == 1;
  }));
}

/// A shot that was aborted before the trigger's pulse is fired again; no other is: it clicks once.
void TriggerStep::on_shot(host::Shot fired) {
  if (!fired.summary->aborted || rises(*fired.summary) > 0) {
    shot_ = std::move(fired.summary);
  } else if (++repeated_ > ShotStep::kRetries) {
    problem_ = "the shot was aborted: " + fired.summary->abort_reason;
  }
}

Request TriggerStep::step(const Situation& situation) {
  if (!problem_.empty()) return Done{{no_shot(problem_)}};
  if (!shot_) return fire_;
  if (!heard_ && situation.attended) return Ask{"Did the machine's trigger click exactly once?"};
  return Done{{judge(situation)}};
}

StepResult TriggerStep::judge(const Situation& situation) const {
  const int pulses = rises(*shot_);
  std::int64_t on_ns = 0, off_ns = 0;
  for (const event_t& event : pulses_) {
    if (event.boot_id != shot_->boot_id || event.shot_id != shot_->shot_id) continue;
    (event.level == 1 ? on_ns : off_ns) = event.device_time_ns;
  }
  const double width_ms = 1e-6 * static_cast<double>(off_ns - on_ns);
  const double wanted_ms = 1e3 * situation.rig.machine_pulse_s.value_or(0.0);
  StepResult result;
  if (pulses != 1 || off_ns <= on_ns) {
    result = failed("trigger_line", fmt::format("the trigger's line rose {} times in the shot", pulses),
                    "run `strobed --check`, and look at the session's journal");
  } else if (std::abs(width_ms - wanted_ms) > kPulseTolerance_ms) {
    result = failed("trigger_pulse",
                    fmt::format("the trigger's pulse was {:.1f} ms long, the rig file says {:.1f} ms",
                                width_ms, wanted_ms),
                    "the rig's computer is too busy: see `strobed --check`");
  } else if (heard_ == false) {
    result = failed("no_click", "the line was pulsed once, and the machine did not click once",
                    "look at the e-stop's and the key's contacts in the machine's trigger circuit, the "
                    "one-shot and the relay");
  } else {
    result.state = StepState::passed;
    result.words = fmt::format("one pulse of {:.1f} ms{}", width_ms,
                               heard_ ? ", and one click heard" : "; no person was asked for the click");
  }
  result.value = width_ms;
  result.unit = "ms";
  result.limit = fmt::format("one pulse of {:.1f} ms", wanted_ms);
  result.figures = {{"pulses", static_cast<double>(pulses), {}, 1.0, 0},
                    {"pulse_ms", width_ms, {}, wanted_ms, 0}};
  return result;
}

}  // namespace

std::unique_ptr<Step> trigger_step() { return std::make_unique<TriggerStep>(); }

}  // namespace strobe::commission
