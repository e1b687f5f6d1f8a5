// Commissioning: takes a rig through its steps, one at a time, on a host loop. Fires what a step asks for,
// with a person's consent to each step; hands on what a person does and answers; leaves out what an earlier
// record has proven. step() is to be called after each turn of the loop. No I/O of its own; single-threaded;
// never waits.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/shot/recent_map.hpp"
#include "host/commission/record/record.hpp"
#include "host/commission/step.hpp"
#include "host/loop/host_loop.hpp"
#include "host/session/shot_series.hpp"

namespace strobe::commission {

struct CommissioningSettings {
  host::RigFile rig;
  bool attended = true;  ///< a person answers; false: every question is answered with yes
  Duration patience = std::chrono::seconds{60};  ///< for each thing that a person is to do
  std::set<std::string> only;  ///< steps to do, also those that have passed; empty: all that are due
  std::string from;            ///< the first step to do, all after it too; empty: the first that is due
  std::map<std::string, std::string> skip;  ///< steps that a person leaves out, each with the reason
  WallTime now;                             ///< a record is old as of this
};

/// A step for whoever shows it.
struct StepView {
  StepInfo info;
  Needs needs;
  StepState state = StepState::pending;
  std::optional<StepResult> result;  ///< also of an earlier run
};

/// What a person is asked. Only who stands at the console may answer what makes outputs move.
struct Prompt {
  enum class Kind {
    begin,         ///< a step, after its briefing: yes, skip or end
    question,      ///< yes or no
    after_failure  ///< again (yes), go on (no), or end
  };
  Kind kind = Kind::begin;
  std::string words;
  bool moves = false;  ///< a yes makes outputs move
};
enum class Answer { yes, no, skip, end };
/// Of a line typed at the console, without its end: y, n, s or q, and an empty one where nothing moves.
/// Absent: no answer.
std::optional<Answer> answer_of(const Prompt& prompt, std::string_view line);

/// Who hears what becomes of it. The default is to ignore it.
class CommissioningListener {
 public:
  virtual ~CommissioningListener() = default;
  virtual void on_prompt(const StepView&, const Prompt&) {}
  /// The step waits for something else now; act: for a person to do.
  virtual void on_waiting(const StepView&, const std::string& /*words*/, Act) {}
  virtual void on_result(const StepView&) {}
};

class Commissioning final : public host::HostListener {
 public:
  /// Adds itself to the loop's listeners; the loop must be the longer-lived and have a key. former: what is
  /// recorded.
  Commissioning(host::HostLoop& loop, CommissioningSettings settings,
                std::vector<std::unique_ptr<Step>> steps, const Record& former);

  void add_listener(CommissioningListener& listener) { listeners_.push_back(&listener); }

  void step();
  /// Ends: a shot under way is aborted, the rig disarmed until that is confirmed, for ten seconds at most.
  /// What is recorded stays. by: who asks, for a person.
  void stop(const std::string& by);
  bool finished() const { return phase_ == Phase::finished; }
  bool stopped() const { return stopped_; }

  /// What a person is asked at the moment.
  const std::optional<Prompt>& prompt() const { return prompt_; }
  void answer(Answer answer);
  /// More time for what a person is doing.
  void stretch();

  const std::vector<StepView>& views() const { return views_; }
  /// What is waited for, in words; empty: nothing.
  const std::string& waiting() const { return waiting_; }

  void on_event(const strobe_msgs::event_t& event) override;
  void on_shot(const strobe_msgs::shot_t& shot) override;
  void on_shot_result(const host::Shot& result) override;
  void on_photograph(const host::KeptPhotograph& kept) override;

 private:
  enum class Phase { choosing, asking, running, firing, disarming, finished };
  struct Work {
    std::unique_ptr<Step> step;
    std::vector<std::size_t> views;  ///< of its infos
    bool due = false;
  };

  void choose_due(const Record& former);
  void choose();
  std::optional<std::string> why_not(const Work& work) const;
  void begin();
  void run();
  void fire(const Fire& wanted);
  void go_on_firing();
  void deliver();
  void finish_step(std::vector<StepResult> results);
  void leave_out(const std::string& words, const std::string& advice, StepState state);
  void next_step();
  void ask(Prompt prompt);
  void wait(const std::string& words, Act act);
  void set_state(StepState state);
  void end();
  bool passed(const std::string& id) const;
  bool rig_stopped() const;
  Situation situation() const;
  StepView& view() { return views_[work_[current_].views.front()]; }

  host::HostLoop& loop_;
  CommissioningSettings settings_;
  std::vector<Work> work_;
  std::vector<StepView> views_;
  std::vector<CommissioningListener*> listeners_;
  Phase phase_ = Phase::choosing;
  bool stopped_ = false;
  bool stopped_in_step_ = false;  ///< the rig, while a step wanted to fire
  std::size_t current_ = 0;
  std::optional<Prompt> prompt_;
  std::string waiting_;
  Duration stretched_{};
  HostTime entered_;

  std::optional<host::ShotSeries> series_;
  Fire wanted_;
  std::optional<host::Shot> result_;
  HostTime result_at_;
  RecentMap<ShotKey, strobe_msgs::shot_t> shots_{16};
  RecentMap<ShotKey, bool> delivered_{64};
  RecentMap<ShotKey, std::filesystem::path> photographs_{64};
};

}  // namespace strobe::commission
