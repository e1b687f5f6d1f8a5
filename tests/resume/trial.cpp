#include "tests/resume/trial.hpp"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <map>
#include <random>
#include <set>
#include <strobe_msgs/event_t.hpp>

#include "host/archive/read_session.hpp"
#include "tests/hil/line_watcher.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/short_shots.hpp"
#include "tests/support/json_lines.hpp"

namespace strobe::resume {

namespace {

using namespace std::chrono_literals;
using hil::RigFixture;
using hil::RigFixtureOptions;
using testing::Command;
using testing::ExitStatus;
using testing::Process;

constexpr auto kShotComes = 60s;
constexpr auto kEnds = 240s;

/// strobed again whenever it has ended, until the bench is taken down.
const char* const kAgain = "until [ -e \"$5/stop\" ]; do \"$@\"; done";

RigFixtureOptions rig_options(const Trial& trial, const std::filesystem::path& camera) {
  RigFixtureOptions options;
  options.seed = trial.seed;
  options.rig_edits = hil::kShortExposure;
  // Nothing here judges flashes: a loop that is awake before each would only take a core from the others.
  options.rig_edits.emplace_back("wake_ahead_us = 4000", "wake_ahead_us = 0");
  options.shell = kAgain;
  if (!trial.photographs) return options;
  return with_small_photographs(options, camera);
}

enum class Kind { kill, first_interrupt, two_interrupts, terminate, quit, full_disk, firmware_killed };
constexpr std::array kNames{"the host killed", "Ctrl-C",      "Ctrl-C twice",  "SIGTERM",
                            "Ctrl-\\",         "a full disk", "strobed killed"};

class Session {
 public:
  explicit Session(const Trial& trial)
      : trial_(trial), random_(trial.seed), bench_(rig_options(trial, camera_.path())) {}

  Verdict run() {
    if (!bench_.ready()) {
      verdict_.violations.push_back("strobed does not start: " + bench_.log());
      return std::move(verdict_);
    }
    for (int i = 0; i < trial_.interruptions; ++i) interrupt(static_cast<Kind>(number(0, 6)));
    Process last(command({}), bench_.folder());
    const auto ended = last.wait(kEnds);
    verdict_.words += last.err();
    if (ended != ExitStatus({0, 0})) violate("the session did not come to its shots");
    nothing_is_fired_once_it_has_them();
    take_down();
    judge();
    verdict_.words += bench_.log();
    return std::move(verdict_);
  }

 private:
  int number(int from, int to) { return std::uniform_int_distribution<int>(from, to)(random_); }
  void violate(std::string what) { verdict_.violations.push_back(std::move(what)); }
  std::filesystem::path folder() const { return bench_.folder() / "host"; }

  /// --resume where a run was recorded and the draw says so, else --until, which say the same here.
  Command command(const std::map<std::string, std::string>& environment) {
    std::vector<std::string> words{"fire", "--session", folder(), "--retries", "50", "--plain"};
    const bool recorded = !testing::read_text(folder() / "runs.jsonl").empty();
    if (recorded && number(0, 1) == 1) {
      words.push_back("--resume");
    } else {
      words.insert(words.end(), {"--until", std::to_string(trial_.shots)});
    }
    if (trial_.photographs) words.insert(words.end(), {"--photographs", camera_.path(), "--effort", "fast"});
    Command command = bench_.strobe(words);
    command.environment = environment;
    return command;
  }

  /// The writes to one of the session's files fail from a drawn one on.
  std::map<std::string, std::string> full_disk() {
    constexpr std::array kFiles{"host-", "results.csv", "flashes.csv", "shots.txt", "runs.jsonl"};
    const std::string file = kFiles.at(static_cast<std::size_t>(number(0, 4)));
    const int nth = file == "host-" ? number(1, 900) : number(1, 2);
    log_lost_ = log_lost_ || file == "host-";
    verdict_.happened += fmt::format("({} from write {}) ", file, nth);
    return {{"LD_PRELOAD", STROBE_DISK_FAULTS},
            {"STROBE_DISK_FAULT", fmt::format("folder={},file={},call=write,nth={},times=1000000,error={}",
                                              folder().string(), file, nth, ENOSPC)}};
  }

  /// Somewhere from the shutter's opening to some time after the readout. Returns false if the run has ended before.
  bool instant_of_a_shot(Process& host) {
    hil::LineWatcher watch(bench_.chip_dir());
    while (watch.wait_for("SHUTTER", 1, 500ms) == 0)
      if (!host.running()) return false;
    testing::sleep_for(std::chrono::milliseconds(number(0, trial_.photographs ? 4000 : 900)));
    return true;
  }

  void interrupt(Kind kind) {
    verdict_.happened += std::string(kNames.at(static_cast<std::size_t>(kind))) + " ";
    Process host(command(kind == Kind::full_disk ? full_disk() : std::map<std::string, std::string>{}),
                 bench_.folder());
    if (kind != Kind::full_disk && instant_of_a_shot(host)) strike(kind, host);
    const auto ended = host.wait(kEnds);
    if (!ended)
      violate(std::string("the host did not end after ") + kNames.at(static_cast<std::size_t>(kind)));
    verdict_.words += host.err();
  }

  void strike(Kind kind, Process& host) {
    switch (kind) {
      case Kind::kill:
        return host.signal(SIGKILL);
      case Kind::first_interrupt:
        return host.signal(SIGINT);
      case Kind::two_interrupts:
        host.signal(SIGINT);
        testing::sleep_for(std::chrono::milliseconds(number(0, 300)));
        return host.signal(SIGINT);
      case Kind::terminate:
        return host.signal(SIGTERM);
      case Kind::quit:
        return host.signal(SIGQUIT);
      case Kind::firmware_killed:
        if (const pid_t worker = bench_.worker(); worker != 0) ::kill(worker, SIGKILL);
        return host.signal(SIGKILL);
      case Kind::full_disk:
        return;
    }
  }

  void nothing_is_fired_once_it_has_them() {
    const std::size_t before = shots_in_journals().size();
    std::vector<std::string> words{"fire", "--session", folder(), "--until", std::to_string(trial_.shots)};
    const auto again = testing::run_process(bench_.strobe(words), kEnds);
    verdict_.words += again.err;
    if (again.status != ExitStatus({0, 0})) violate("a session that has its shots is not told to be done");
    if (shots_in_journals().size() != before) violate("a shot was fired that was not wanted");
  }

  void take_down() {
    testing::write_text(bench_.session() / "stop", "");
    if (const pid_t guardian = bench_.guardian(); guardian != 0) ::kill(guardian, SIGTERM);
    bench_.sim().wait(20s);
  }

  using Key = std::pair<std::uint64_t, int>;  // boot, shot

  /// All that were begun, and whether they came to an end.
  std::map<Key, bool> shots_in_journals() const {
    std::map<Key, bool> shots;
    for (const auto& entry : std::filesystem::directory_iterator(bench_.session())) {
      if (!entry.path().filename().string().starts_with("journal-")) continue;
      const hil::LogContents journal = hil::read_log(entry.path());
      for (const auto& event : journal.events) {
        if (event.kind == strobe_msgs::event_t::SHOT_STARTED)
          shots.try_emplace({static_cast<std::uint64_t>(event.boot_id), event.shot_id}, false);
      }
      for (const auto& shot : journal.shots)
        shots[{static_cast<std::uint64_t>(shot.boot_id), shot.shot_id}] = true;
    }
    return shots;
  }

  void judge() {
    const auto table = testing::read_csv(folder() / "results.csv");
    std::map<Key, int> rows;
    std::map<Key, bool> counts;
    for (const auto& row : table.rows) {
      const Key key{std::stoull(row.at(table.column("boot_id")), nullptr, 16),
                    std::stoi(row.at(table.column("shot_id")))};
      if (++rows[key] == 2) violate(fmt::format("shot {} is in the table twice", key.second));
      counts[key] = row.at(table.column("rejected")).empty();
      verdict_.counted += counts[key] ? 1 : 0;
    }
    verdict_.rows = static_cast<int>(table.rows.size());
    if (verdict_.counted != trial_.shots)
      violate(fmt::format("{} shots count, and {} were asked for", verdict_.counted, trial_.shots));
    const auto fired = shots_in_journals();
    for (const auto& [key, ended] : fired) {
      ++verdict_.fired;
      verdict_.cut_off += ended ? 0 : 1;
      if (!rows.contains(key)) violate(fmt::format("shot {} was fired and is in no row", key.second));
    }
    for (const auto& [key, count] : rows)
      if (!fired.contains(key)) violate(fmt::format("shot {} is in the table and in no journal", key.second));
    if (!log_lost_) judge_by_the_logs(counts);
    std::set<int> numbers;
    for (const auto& [key, count] : rows) numbers.insert(key.second);
    int nameless = 0;  // the simulator knows a shot's number from its summary
    for (const auto& truth : bench_.truths()) {
      const int id = truth.at("shot_id").get<int>();
      nameless += id == 0 ? 1 : 0;
      if (id != 0 && !numbers.contains(id))
        violate(fmt::format("the ball of shot {} was thrown and is in no row", id));
    }
    if (nameless > verdict_.cut_off)
      violate(fmt::format("{} balls were thrown in shots without an end, of which there are {}", nameless,
                          verdict_.cut_off));
  }

  /// The folder read back, as every other command does: the same shots, and the same of them count.
  void judge_by_the_logs(const std::map<Key, bool>& counts) {
    const auto session = host::read_session(folder(), {bench_.rig_file(), "", {}});
    if (!session) return violate("the session cannot be read back: " + session.error().message);
    std::map<Key, bool> read;
    for (const host::StoredShot& shot : session->shots)
      read[{static_cast<std::uint64_t>(shot.key.boot_id), shot.key.shot_id}] = !shot.result.rejected;
    for (const auto& [key, counted] : counts) {
      if (!read.contains(key)) {
        violate(fmt::format("shot {} is in the table and is not read back from the folder", key.second));
      } else if (read.at(key) != counted) {
        violate(fmt::format("shot {} {} in the table, and read back from the folder it {}", key.second,
                            counted ? "counts" : "does not count", counted ? "does not" : "does"));
      }
    }
    for (const auto& [key, counted] : read)
      if (!counts.contains(key)) violate(fmt::format("shot {} is read back and is in no row", key.second));
  }

  const Trial& trial_;
  std::mt19937_64 random_;
  testing::TemporaryFolder camera_;
  RigFixture bench_;
  bool log_lost_ = false;  ///< what the host heard could not all be kept, and it said so
  Verdict verdict_;
};

}  // namespace

Verdict run_trial(const Trial& trial) { return Session(trial).run(); }

}  // namespace strobe::resume
