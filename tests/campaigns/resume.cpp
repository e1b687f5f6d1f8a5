#include "tests/campaigns/resume.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <map>
#include <set>
#include <strobe_msgs/event_t.hpp>

#include "common/shot/shot_key.hpp"
#include "host/archive/read_session.hpp"
#include "tests/campaigns/series_lab.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/support/json_lines.hpp"

namespace strobe::resume {

namespace {

using campaigns::Draws;
using campaigns::Verdict;
using testing::Command;
using testing::ExitStatus;
using testing::Process;

hil::RigFixtureOptions rig_options(const Trial& trial, const Draws& draws,
                                   const std::filesystem::path& camera) {
  const hil::RigFixtureOptions options = campaigns::series_rig(draws, true);
  return trial.photographs ? with_small_photographs(options, camera) : options;
}

struct Interruption {
  const char* name;
  std::vector<int> signals;  ///< to the host; none: its disk is full
  bool of_strobed = false;   ///< which is killed before
};
const std::vector<Interruption> kInterruptions{{"the host killed", {SIGKILL}},
                                               {"Ctrl-C", {SIGINT}},
                                               {"Ctrl-C twice", {SIGINT, SIGINT}},
                                               {"SIGTERM", {SIGTERM}},
                                               {"Ctrl-\\", {SIGQUIT}},
                                               {"a full disk", {}},
                                               {"strobed killed", {SIGKILL}, true}};

/// With the folder of its camera.
class Session : testing::TemporaryFolder, campaigns::SeriesLab {
 public:
  Session(const Trial& trial, Draws& draws)
      : SeriesLab(rig_options(trial, draws, TemporaryFolder::path()), draws), trial_(trial) {}

  Verdict run() {
    for (int i = 0; i < trial_.interruptions; ++i) interrupt(draws_.choice(kInterruptions));
    Process last(command({}), rig_.folder());
    if (end_of(last) != ExitStatus({0, 0})) verdict_.violate("the session did not come to its shots");
    nothing_is_fired_once_it_has_them();
    take_down();
    judge();
    verdict_.rows = {{"shots by", trial_.photographs ? "photographs" : "the tablet"}};
    return std::move(verdict_);
  }

 private:
  /// --resume where a run was recorded and the draw says so, else --until, which say the same here.
  Command command(const std::map<std::string, std::string>& environment) {
    std::vector<std::string> words{"fire", "--session", host_folder(), "--retries", "50", "--plain"};
    const bool recorded = !testing::read_text(host_folder() / "runs.jsonl").empty();
    if (recorded && draws_.chance(0.5)) {
      words.push_back("--resume");
    } else {
      words.insert(words.end(), {"--until", std::to_string(trial_.shots)});
    }
    if (trial_.photographs)
      words.insert(words.end(), {"--photographs", TemporaryFolder::path(), "--effort", "fast"});
    Command command = rig_.strobe(words);
    command.environment = environment;
    return command;
  }

  /// The writes to one of the session's files fail from a drawn one on.
  std::map<std::string, std::string> full_disk() {
    constexpr std::array kFiles{"host-", "results.csv", "flashes.csv", "shots.txt", "runs.jsonl"};
    const std::string file = draws_.choice(kFiles);
    const int nth = draws_.between(1, file == "host-" ? 900 : 2);
    log_lost_ = log_lost_ || file == "host-";
    verdict_.trial += fmt::format(" ({} from write {})", file, nth);
    return {{"LD_PRELOAD", STROBE_DISK_FAULTS},
            {"STROBE_DISK_FAULT", fmt::format("folder={},file={},call=write,nth={},times=1000000,error={}",
                                              host_folder().string(), file, nth, ENOSPC)}};
  }

  void interrupt(const Interruption& how) {
    verdict_.trial += fmt::format("{}{}", verdict_.trial.empty() ? "" : ", ", how.name);
    Process host(command(how.signals.empty() ? full_disk() : std::map<std::string, std::string>{}),
                 rig_.folder());
    // Somewhere from the shutter's opening to some time after the readout.
    if (!how.signals.empty() && reach_instant_of_a_shot(host, trial_.photographs ? 4000 : 900))
      strike(how, host);
    if (!end_of(host)) verdict_.violate("the host did not end after {}", how.name);
  }

  void strike(const Interruption& how, Process& host) {
    const pid_t worker = how.of_strobed ? rig_.worker() : 0;
    if (worker != 0) kill(worker, SIGKILL);
    for (std::size_t i = 0; i < how.signals.size(); ++i) {
      if (i > 0) testing::sleep_for(std::chrono::milliseconds(draws_.between(0, 300)));
      host.signal(how.signals[i]);
    }
  }

  void nothing_is_fired_once_it_has_them() {
    const std::size_t before = shots_in_journals().size();
    std::vector<std::string> words{"fire", "--session", host_folder(), "--until",
                                   std::to_string(trial_.shots)};
    Process again(rig_.strobe(words), rig_.folder());
    if (end_of(again) != ExitStatus({0, 0}))
      verdict_.violate("a session that has its shots is not told to be done");
    if (shots_in_journals().size() != before) verdict_.violate("a shot was fired that was not wanted");
  }

  /// All that were begun, and whether they came to an end.
  std::map<ShotKey, bool> shots_in_journals() const {
    std::map<ShotKey, bool> shots;
    for (const auto& entry : std::filesystem::directory_iterator(rig_.session())) {
      if (!entry.path().filename().string().starts_with("journal-")) continue;
      const hil::LogContents journal = hil::read_log(entry.path());
      for (const auto& event : journal.events) {
        if (event.kind == strobe_msgs::event_t::SHOT_STARTED)
          shots.try_emplace({event.boot_id, event.shot_id}, false);
      }
      for (const auto& shot : journal.shots) shots[{shot.boot_id, shot.shot_id}] = true;
    }
    return shots;
  }

  void judge() {
    const auto table = testing::read_csv(host_folder() / "results.csv");
    std::map<ShotKey, bool> counts;  // those in the table
    int counted = 0, cut_off = 0;
    for (const auto& row : table.rows) {
      const ShotKey key{static_cast<std::int64_t>(std::stoull(row.at(table.column("boot_id")), nullptr, 16)),
                        std::stoi(row.at(table.column("shot_id")))};
      if (counts.contains(key)) verdict_.violate("shot {} is in the table twice", key.shot_id);
      counts[key] = row.at(table.column("rejected")).empty();
      counted += counts[key] ? 1 : 0;
    }
    if (counted != trial_.shots)
      verdict_.violate("{} shots count, and {} were asked for", counted, trial_.shots);
    const auto fired = shots_in_journals();
    for (const auto& [key, ended] : fired) {
      cut_off += ended ? 0 : 1;
      if (!counts.contains(key)) verdict_.violate("shot {} was fired and is in no row", key.shot_id);
    }
    for (const auto& [key, count] : counts)
      if (!fired.contains(key)) verdict_.violate("shot {} is in the table and in no journal", key.shot_id);
    if (!log_lost_) judge_by_the_logs(counts);
    std::set<int> numbers;
    for (const auto& [key, count] : counts) numbers.insert(key.shot_id);
    int nameless = 0;  // the simulator knows a shot's number from its summary
    for (const auto& truth : rig_.truths()) {
      const int id = truth.at("shot_id").get<int>();
      nameless += id == 0 ? 1 : 0;
      if (id != 0 && !numbers.contains(id))
        verdict_.violate("the ball of shot {} was thrown and is in no row", id);
    }
    if (nameless > cut_off)
      verdict_.violate("{} balls were thrown in shots without an end, of which there are {}", nameless,
                       cut_off);
    verdict_.counts = {{"fired", fired.size()},
                       {"without an end", cut_off},
                       {"rows", table.rows.size()},
                       {"count", counted}};
  }

  /// The folder read back, as every other command does: the same shots, and the same of them count.
  void judge_by_the_logs(const std::map<ShotKey, bool>& counts) {
    const auto session = host::read_session(host_folder(), {rig_.rig_file(), "", {}});
    if (!session) return verdict_.violate("the session cannot be read back: {}", session.error().message);
    std::map<ShotKey, bool> read;
    for (const host::Shot& shot : session->shots) read[shot.key()] = !shot.rejected;
    for (const auto& [key, counted] : counts) {
      if (!read.contains(key)) {
        verdict_.violate("shot {} is in the table and is not read back from the folder", key.shot_id);
      } else if (read.at(key) != counted) {
        verdict_.violate("shot {} {} in the table, and read back from the folder it {}", key.shot_id,
                         counted ? "counts" : "does not count", counted ? "does not" : "does");
      }
    }
    for (const auto& [key, counted] : read)
      if (!counts.contains(key)) verdict_.violate("shot {} is read back and is in no row", key.shot_id);
  }

  const Trial& trial_;
  bool log_lost_ = false;  ///< what the host heard could not all be kept, and it said so
};

}  // namespace

Trial drawn(const Trial& wanted, const Draws& draws) {
  Trial trial = wanted;
  trial.photographs = trial.photographs || draws.number() % 4 == 0;
  return trial;
}

Verdict run_trial(const Trial& trial, Draws& draws) { return Session(trial, draws).run(); }

}  // namespace strobe::resume
