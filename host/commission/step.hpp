// A step of commissioning: what it is about, and a state machine that asks for what it needs (a shot, a
// person's answer) until it has its results. Driven by Commissioning on the host loop's thread; knows no
// clock, link or console of its own, so that it runs on virtual time as well. Single-threaded; never waits.
#pragma once

#include <optional>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/status_t.hpp>
#include <variant>
#include <vector>

#include "common/shot/shot_plan.hpp"
#include "common/units/time.hpp"
#include "host/commission/record/step_result.hpp"
#include "host/config/rig_file.hpp"
#include "host/session/shot.hpp"

namespace strobe::commission {

/// What a step makes use of.
struct Needs {
  bool operator_acts = false;  ///< a person turns, presses or pulls something meanwhile
  bool outputs = false;        ///< lamps and shutter move
  bool machine = false;        ///< the machine's trigger is pulsed: key and e-stop must have passed
  bool photographs = false;    ///< the camera's folder must be known
};

/// What there is to judge by.
struct Situation {
  HostTime now;
  std::optional<strobe_msgs::status_t> status;  ///< absent: the firmware is silent
  const host::RigFile& rig;
  std::string danger;          ///< outputs that may be active; else empty
  bool verified = true;        ///< all that is acted on has the lab's seal
  std::int64_t other_key = 0;  ///< packets with another lab's seal
  bool camera = false;         ///< photographs are taken in
  bool attended = true;        ///< a person answers; false: --yes
  Duration patience{};         ///< for each thing that a person is to do
};

/// What a person is to do. The names are for scripts and stay.
enum class Act {
  none,
  key_off,
  key_on,
  key_wire_off,  ///< the key's wire is pulled
  key_wire_on,   ///< and put back
  estop_press,
  estop_release,
  estop_wire_off,
  estop_wire_on,
};
inline constexpr std::array<std::string_view, 9> kActNames{
    "none",        "key_off",       "key_on",         "key_wire_off", "key_wire_on",
    "estop_press", "estop_release", "estop_wire_off", "estop_wire_on"};
constexpr std::string_view name(Act act) { return kActNames[static_cast<std::size_t>(act)]; }

/// What a step asks for. The words are for a person.
struct Wait {
  std::string words;    ///< for what: "turn the key on"
  Act act = Act::none;  ///< that a person is to do: the time for it can be stretched
};
struct Fire {
  ShotPlan plan;
  std::string words;        ///< "lamp A flashes 100 times"
  bool photograph = false;  ///< the shot is complete once its photograph is here, or will not come
  bool readout = true;      ///< and once it has been measured; false: its summary is all that is waited for
};
struct Ask {
  std::string question;  ///< that yes or no answers
};
struct Done {
  std::vector<StepResult> results;  ///< one for each of infos(), in their order
};
using Request = std::variant<Wait, Fire, Ask, Done>;

class Step {
 public:
  Step(std::vector<StepInfo> infos, Needs needs) : infos_(std::move(infos)), needs_(needs) {}
  virtual ~Step() = default;
  const std::vector<StepInfo>& infos() const { return infos_; }
  const Needs& needs() const { return needs_; }
  /// What will happen, what moves and what to do first: a sentence or more, for a person, before anything
  /// happens.
  virtual std::string briefing(const host::RigFile& rig) const = 0;

  /// Begins, also anew. The rig file stays as it is until the step is over.
  virtual void begin(const Situation& situation) = 0;
  /// What the step wants now. Fire and Ask are answered once each, by on_shot() or on_answer(), before this
  /// is called again.
  virtual Request step(const Situation& situation) = 0;

  virtual void on_event(const strobe_msgs::event_t& /*event*/, HostTime /*now*/) {}
  /// A shot that the step asked for, with its summary and all its events, and its photograph if one came.
  virtual void on_shot(host::Shot /*shot*/) {}
  /// The shot could not be fired, or not to its end; why, for a person.
  virtual void on_no_shot(const std::string& /*why*/) {}
  virtual void on_answer(bool /*yes*/) {}

 private:
  std::vector<StepInfo> infos_;
  Needs needs_;
};

}  // namespace strobe::commission
