#include "tests/campaigns/loss.hpp"

#include <fmt/format.h>

#include <csignal>
#include <stdexcept>

#include "tests/campaigns/series_rig.hpp"
#include "tests/hil/line_watcher.hpp"
#include "tests/support/private_network.hpp"

namespace strobe::loss {

namespace {

using campaigns::Draws;
using campaigns::kSeriesEnds;
using testing::ExitStatus;
using testing::Process;

hil::RigFixtureOptions rig_options(const Trial& trial, const Draws& draws) {
  const auto options = campaigns::series_rig(draws.seed(), trial.full_exposure);
  return trial.victim == Victim::nobody ? options : campaigns::with_strobed_again(options);
}

/// A bench, and hosts on another network that is joined with it by a relay.
class Lab {
 public:
  Lab(const Trial& trial, Draws& draws)
      : trial_(trial),
        draws_(draws),
        bench_(rig_options(trial, draws)),
        relay_(bench_.lcm_url(), host_url_, trial.faults, draws.seed()) {
    if (!bench_.ready()) throw std::runtime_error("strobed does not start: " + bench_.log());
  }

  Outcome run() {
    const bool ended = trial_.victim == Victim::nobody ? lose()
                       : trial_.victim == Victim::host ? kill_hosts()
                                                       : kill_firmwares();
    campaigns::take_down(bench_);  // so that every shot has its end
    outcome_.audit = audit(bench_.session(), host_folder());
    outcome_.link = relay_.counts();
    outcome_.violations = outcome_.audit.violations;
    if (!ended) outcome_.violate("the series did not end as ordered");
    if (outcome_.audit.journalled == 0) outcome_.violate("the journals have no event");
    outcome_.words += bench_.log();
    return std::move(outcome_);
  }

 private:
  std::filesystem::path host_folder() const { return bench_.folder() / "host"; }

  Process fire(int shots, int retries) {
    testing::Command command =
        bench_.strobe({"fire", "--shots", std::to_string(shots), "--retries", std::to_string(retries),
                       "--session", host_folder(), "--plain"});
    command.arguments.back() = host_url_;
    return bench_.start(command);
  }

  bool ends_in_order(Process& host) {
    const auto status = host.wait(kSeriesEnds);
    outcome_.words += host.err();
    return status == ExitStatus({0, 0});
  }
  bool last_series(int shots) {
    Process host = fire(shots, 1000);
    return ends_in_order(host);
  }

  bool lose() {
    Process host = fire(trial_.shots, 1000);
    if (trial_.cut_s > 0.0 && reach_instant_of_a_shot(bench_, host, draws_, 300)) {
      relay_.cut(true);
      testing::sleep_for(std::chrono::milliseconds(static_cast<int>(trial_.cut_s * 1e3)));
      relay_.cut(false);
    }
    return ends_in_order(host);
  }

  /// Each host fires one shot and dies in it; the next one takes over its folder.
  bool kill_hosts() {
    for (; outcome_.kills < trial_.kills; ++outcome_.kills) {
      Process host = fire(1, 1000);
      if (!reaches_shot(host)) return false;
      host.signal(SIGKILL);
      host.wait(std::chrono::seconds(5));
    }
    return last_series(1);
  }

  /// The firmware dies in a shot of each host, whose series ends with it; the next one takes over its folder.
  bool kill_firmwares() {
    while (outcome_.kills < trial_.kills) {
      Process host = fire(100'000, 100'000);
      if (!reaches_shot(host)) return false;
      const pid_t worker = bench_.worker(), guardian = bench_.guardian();
      if (worker == 0) continue;
      if (draws_.chance(1.0 / 3.0)) kill(guardian, SIGKILL);
      kill(worker, SIGKILL);
      ++outcome_.kills;
      host.wait(kSeriesEnds);
      outcome_.words += host.err();
    }
    return last_series(2);  // what the last death left has then been told and fetched
  }

  bool reaches_shot(Process& host) {
    if (reach_instant_of_a_shot(bench_, host, draws_, trial_.full_exposure ? 1000 : 600)) return true;
    outcome_.words += "no shot came\n";
    return false;
  }

  const Trial& trial_;
  Draws& draws_;
  hil::RigFixture bench_;
  std::string host_url_ = testing::private_lcm_url();
  LossyLink relay_;
  Outcome outcome_;
};

void report(const Trial& trial, Outcome& outcome) {
  const Audit& a = outcome.audit;
  outcome.trial = fmt::format("{}, {} kills, {:.0f} s", trial.name, outcome.kills, outcome.duration_s);
  outcome.rows = {{"what", trial.name}};
  const auto add = [&outcome](const char* what, auto value) {
    outcome.counts.push_back({what, static_cast<double>(value)});
  };
  add("kills", outcome.kills);
  add("boots", a.boots);
  add("packets", outcome.link.came);
  add("lost", outcome.link.lost + outcome.link.cut);
  add("events journalled", a.journalled);
  add("missing events", a.missing);
  add("missing summaries", a.shots_missing);
  add("shots cut off", a.cut_off);
  add("of them reported", a.cut_off_reported);
  add("readouts", a.readouts);
  add("of them flagged", a.flagged);
  add("twice", a.twice);
  add("incomplete unflagged", a.incomplete_unflagged);
  add("s", outcome.duration_s);
}

const std::vector<Trial>& links() {
  constexpr auto kNobody = Victim::nobody;
  static const std::vector<Trial> links{
      {"no loss", kNobody, {}},
      {"5 % loss", kNobody, {0.05, 0, 0, 60}},
      {"20 % loss", kNobody, {0.2, 0, 0, 60}},
      {"50 % loss", kNobody, {0.5, 0, 0, 60}},
      {"20 % doubled", kNobody, {0, 0.2, 0, 60}},
      {"20 % late by up to 60 ms", kNobody, {0, 0, 0.2, 60}},
      {"20 % lost, 10 % doubled, 20 % late", kNobody, {0.2, 0.1, 0.2, 60}},
      {"cut for 10 s in a shot", kNobody, {}, 10},
      {"20 % loss, cut for 10 s", kNobody, {0.2, 0, 0, 60}, 10},
  };
  return links;
}

}  // namespace

Outcome run_trial(const Trial& trial, Draws& draws) {
  const std::int64_t start_ns = testing::monotonic_now_ns();
  Outcome outcome = Lab(trial, draws).run();
  outcome.duration_s = static_cast<double>(testing::monotonic_now_ns() - start_ns) * 1e-9;
  report(trial, outcome);
  return outcome;
}

Trial drawn(const Choice& choice, const Draws& draws) {
  const bool both = !choice.links && choice.kills == 0;
  std::vector<Trial> trials;
  if (choice.links || both) trials = links();
  if (choice.kills > 0 || both) {
    const std::string loss =
        choice.kill_loss > 0 ? fmt::format(", {:.0f} % loss", choice.kill_loss * 100) : "";
    trials.push_back({"the host killed" + loss, Victim::host, {choice.kill_loss}});
    trials.push_back({"strobed killed" + loss, Victim::firmware, {choice.kill_loss}});
  }
  Trial trial = trials[static_cast<std::size_t>(draws.number() - 1) % trials.size()];
  trial.shots = choice.shots;
  trial.kills = both ? 100 : choice.kills;
  trial.full_exposure = choice.full_exposure;
  return trial;
}

}  // namespace strobe::loss
