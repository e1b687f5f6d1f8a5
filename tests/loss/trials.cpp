#include "tests/loss/trials.hpp"

#include <csignal>
#include <random>

#include "tests/hil/line_watcher.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/support/private_network.hpp"

namespace strobe::loss {

namespace {

using namespace std::chrono_literals;
using hil::LineWatcher;
using hil::RigFixture;
using hil::RigFixtureOptions;
using testing::Command;
using testing::ExitStatus;
using testing::Process;

constexpr auto kShotComes = 40s;  // a host waits for lost answers, a machine stands still
constexpr auto kSeriesEnds = 240s;

RigFixtureOptions rig_options(bool short_exposure, std::uint64_t seed) {
  RigFixtureOptions options;
  options.seed = seed;
  if (short_exposure) options.rig_edits = hil::kShortExposure;
  // Beside another bench: two loops that are awake leave no core to the simulated rigs.
  options.rig_edits.emplace_back("wake_ahead_us = 4000", "wake_ahead_us = 0");
  return options;
}

/// A bench, and a host on another network that is joined with it by a relay.
class LossFixture {
 public:
  LossFixture(const RigFixtureOptions& options, const LinkFaults& faults, std::uint64_t seed)
      : bench_(options),
        host_url_(testing::private_lcm_url()),
        relay_(bench_.lcm_url(), host_url_, faults, seed) {
    ready_ = bench_.ready();
  }
  bool ready() const { return ready_; }
  RigFixture& bench() { return bench_; }
  LossyLink& relay() { return relay_; }
  std::filesystem::path host_folder() const { return bench_.folder() / "host"; }

  Process fire(int shots, int retries) {
    Command command = bench_.strobe({"fire", "--shots", std::to_string(shots), "--retries",
                                     std::to_string(retries), "--session", host_folder(), "--plain"});
    command.arguments.back() = host_url_;
    return bench_.start(command);
  }

  void audit_into(TrialResult& result) {
    result.audit.add(audit(bench_.session(), host_folder()));
    result.link = relay_.counts();
  }

 private:
  RigFixture bench_;
  std::string host_url_;
  LossyLink relay_;
  bool ready_ = false;
};

double seconds_since(std::int64_t start_ns) {
  return static_cast<double>(testing::monotonic_now_ns() - start_ns) * 1e-9;
}

void end_series(Process& host, TrialResult& result) {
  const auto status = host.wait(kSeriesEnds);
  result.fired = status == ExitStatus({0, 0});
  result.words += host.err();
}

/// strobed again whenever it has ended, until the bench is taken down.
const char* const kAgain = "until [ -e \"$5/stop\" ]; do \"$@\"; done";

void take_down(RigFixture& bench) {
  testing::write_text(bench.session() / "stop", "");
  if (const pid_t guardian = bench.guardian(); guardian != 0) kill(guardian, SIGTERM);
  bench.sim().wait(10s);
}

class KillSequence {
 public:
  KillSequence(const KillTrial& trial, LossFixture& lab, TrialResult& result)
      : trial_(trial), lab_(lab), result_(result), random_(trial.seed), watch_(lab.bench().chip_dir()) {}

  /// Each host fires one shot and dies in it; the next one takes over its folder.
  void hosts() {
    while (result_.kills < trial_.kills) {
      Process host = lab_.fire(1, 1000);
      if (!instant_of_a_shot()) return;
      host.signal(SIGKILL);
      host.wait(5s);
      killed();
    }
    Process last = lab_.fire(1, 1000);
    end_series(last, result_);
  }

  /// The firmware dies in a shot of each host, whose series ends with it; the next one takes over its folder.
  void firmwares() {
    while (result_.kills < trial_.kills) {
      Process host = lab_.fire(100'000, 100'000);
      if (!instant_of_a_shot()) return;
      const pid_t worker = lab_.bench().worker(), guardian = lab_.bench().guardian();
      if (worker == 0) continue;
      if (chance(1.0 / 3.0)) kill(guardian, SIGKILL);
      kill(worker, SIGKILL);
      killed();
      host.wait(kSeriesEnds);
      result_.words += host.err();
    }
    // Two more shots: what the last death left has then been told and fetched.
    Process last = lab_.fire(2, 1000);
    end_series(last, result_);
  }

 private:
  bool chance(double p) { return std::bernoulli_distribution(p)(random_); }
  bool instant_of_a_shot() {
    if (watch_.wait_for("SHUTTER", 1, kShotComes) == 0) {
      result_.words += "no shot came\n";
      return false;
    }
    const double most_ms = trial_.short_exposure ? 600.0 : 1000.0;
    const double ms = std::uniform_real_distribution<double>(0.0, most_ms)(random_);
    testing::sleep_for(std::chrono::milliseconds(static_cast<int>(ms)));
    return true;
  }
  void killed() {
    ++result_.kills;
    trial_.progress(result_.kills);
  }

  const KillTrial& trial_;
  LossFixture& lab_;
  TrialResult& result_;
  std::mt19937_64 random_;
  LineWatcher watch_;
};

/// What happens in a lab whose firmware is up.
TrialResult run_trial(const RigFixtureOptions& options, const LinkFaults& faults, std::uint64_t seed,
                      const std::function<void(LossFixture&, TrialResult&)>& happen) {
  TrialResult result;
  const std::int64_t start_ns = testing::monotonic_now_ns();
  LossFixture lab(options, faults, seed);
  if (!lab.ready()) {
    result.words = lab.bench().log();
    return result;
  }
  happen(lab, result);
  result.duration_s = seconds_since(start_ns);
  return result;
}

}  // namespace

TrialResult run_trial(const LinkTrial& trial) {
  const RigFixtureOptions options = rig_options(trial.short_exposure, trial.seed);
  return run_trial(options, trial.faults, trial.seed, [&trial](LossFixture& lab, TrialResult& result) {
    LineWatcher watch(lab.bench().chip_dir());
    Process host = lab.fire(trial.shots, 1000);
    if (trial.cut_s > 0.0 && watch.wait_for("SHUTTER", 1, kShotComes) != 0) {
      std::mt19937_64 random(trial.seed);
      testing::sleep_for(std::chrono::milliseconds(std::uniform_int_distribution<int>(0, 300)(random)));
      lab.relay().cut(true);
      testing::sleep_for(std::chrono::milliseconds(static_cast<int>(trial.cut_s * 1e3)));
      lab.relay().cut(false);
    }
    end_series(host, result);
    take_down(lab.bench());
    lab.audit_into(result);
    result.words += lab.bench().log();
  });
}

TrialResult run_trial(const KillTrial& trial) {
  RigFixtureOptions options = rig_options(trial.short_exposure, trial.seed);
  options.shell = kAgain;
  LinkFaults faults;
  faults.loss = trial.loss;
  return run_trial(options, faults, trial.seed, [&trial](LossFixture& lab, TrialResult& result) {
    KillSequence killing(trial, lab, result);
    trial.victim == Victim::host ? killing.hosts() : killing.firmwares();
    take_down(lab.bench());  // so that every shot has its end
    lab.audit_into(result);
    result.words += lab.bench().log();
  });
}

}  // namespace strobe::loss
