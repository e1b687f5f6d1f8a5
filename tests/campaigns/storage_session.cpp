#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <lcm/lcm-cpp.hpp>
#include <new>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

#include "common/config/files.hpp"
#include "host/loop/stored_series.hpp"
#include "host/session/results_csv.hpp"
#include "host/session/run_lock.hpp"
#include "tests/campaigns/scripted_bench.hpp"
#include "tests/campaigns/storage.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::storage {
namespace {

namespace fs = std::filesystem;
using campaigns::Verdict;
using Message = ScriptedBench::Message;

constexpr std::int64_t kHost = 0x1234;
constexpr int kShots = 3;
constexpr Duration kLongest = std::chrono::minutes{5};  // of the bench's clock; a series takes some 10 s
constexpr const char* kFirstUtc = "20260131T093000Z";
constexpr const char* kUtc = "20260131T100000Z";

/// A run of the host: what it told, and left behind beside the disk.
struct Run final : host::HostListener {
  explicit Run(int shots_before) : bench(key, shots_before) {}
  void on_notification(const std::string& text) override {
    if (!text.starts_with("the series ends")) told.emplace_back(bench.now(), text);
  }
  void on_shot_result(const host::ShotResult& result) override { results.push_back(result.shot_id); }

  authentication::Key key = authentication::Key::random();
  ScriptedBench bench;
  std::vector<std::pair<Duration, std::string>> told;
  std::vector<int> results;
  std::string refused;
  std::optional<Duration> failed_at;  ///< of the first call that failed
  bool succeeded = false, finished = false;
  bool taken_away = false;
  bool out_of_memory = false;  ///< ended by it, as the program would
  std::vector<std::string> unstored;
};

/// Removes or renames the folder or a file of it, as a person may in the middle of a series. At the so many-th of
/// the host's turns, in tens. True: done now.
bool take_away(const testing::DiskFault& fault, const fs::path& folder, int turn) {
  if (turn != 10 * fault.nth) return false;
  std::error_code error;
  if (fault.call == "rename folder") {
    fs::rename(folder, folder.string() + "-moved", error);
  } else if (fault.call == "remove folder") {
    fs::remove_all(folder, error);
  } else if (fault.call == "remove file") {
    fs::remove(folder / fault.file, error);
  } else {
    return false;
  }
  return !error;
}

void fire(Run& run, const fs::path& folder, const char* utc, int shots, const testing::DiskFault& fault) {
  const auto lock = host::RunLock::of_session(folder, "ann@lab", WallTime{});
  if (!lock) {
    run.refused = lock.error().message;
    return;
  }
  auto opened = host::SessionFolder::open(folder, utc, "rig = \"bench\"\n", "train = \"free\"\n",
                                          {"camera.toml", "px_per_m = 9\n"});
  if (!opened) {
    run.refused = opened.error().message;
    return;
  }
  host::HostLoopSettings settings{"bench", {}, kHost, true, run.key};
  settings.assembly.machine_lag_s = host_test::kMachineLag_s;
  host::ShotSeriesSettings series;
  series.shots = shots;
  host::StoredSeries stored(settings, series, **opened, run.bench, run.bench);
  stored.loop().add_listener(run);
  int turn = 0;
  const auto watch = [&] {
    run.taken_away = run.taken_away || take_away(fault, folder, ++turn);
    if (!run.failed_at && (run.taken_away || testing::disk_faults_injected() > 0))
      run.failed_at = run.bench.now();
  };
  const Duration end = run.bench.now() + kLongest;
  try {
    while (!stored.runner().finished() && run.bench.now() < end) {
      stored.run_once();
      watch();
    }
    run.finished = stored.runner().finished();
    stored.close();
  } catch (const std::bad_alloc&) {
    stored.abandon();
    throw;
  }
  if (!run.failed_at && testing::disk_faults_injected() > 0) run.failed_at = run.bench.now();
  run.succeeded = stored.runner().series().succeeded();
  run.unstored = stored.unstored();
}

struct Log {
  std::vector<Message> messages;
  std::uintmax_t bytes = 0;  ///< of whole records
};

Log read_log(const fs::path& path) {
  constexpr std::uintmax_t kHeader_bytes = 28;
  Log contents;
  std::error_code error;
  if (!fs::exists(path, error)) return contents;
  lcm::LogFile log(path.string(), "r");
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    const auto* data = static_cast<const std::uint8_t*>(event->data);
    contents.messages.emplace_back(event->channel, std::vector<std::uint8_t>(data, data + event->datalen));
    contents.bytes += kHeader_bytes + event->channel.size() + static_cast<std::uintmax_t>(event->datalen);
  }
  return contents;
}

/// How many of `wanted` are not in `there`, which must be some of them in order; -1: it is not.
int missing(const std::vector<Message>& wanted, const std::vector<Message>& there) {
  std::size_t found = 0;
  for (const Message& message : wanted) {
    if (found < there.size() && there[found] == message) ++found;
  }
  return found == there.size() ? static_cast<int>(wanted.size() - found) : -1;
}

struct Before {
  std::string log, results, flashes;
  explicit Before(const fs::path& folder)
      : log(testing::read_text(folder / (std::string("host-") + kFirstUtc + ".lcmlog"))),
        results(testing::read_text(folder / "results.csv")),
        flashes(testing::read_text(folder / "flashes.csv")) {}
};

class Judge {
 public:
  Judge(const fs::path& folder, const testing::DiskFault& fault, const Run& run, const Before& before)
      : folder_(folder), fault_(fault), run_(run), before_(before) {}

  Verdict verdict() {
    if (run_.out_of_memory) return judge_unfinished();
    if (run_.taken_away) {
      judge_what_is_gone();
    } else {
      keeps_what_was_stored();
      judge_log();
      judge_tables();
    }
    judge_words();
    const bool reached = testing::disk_faults_injected() > 0 || run_.taken_away;
    verdict_.words = first_told();
    verdict_.count(!run_.refused.empty()    ? "refused"
                   : !reached               ? "not reached"
                   : verdict_.words.empty() ? "harmless"
                   : run_.unstored.empty()  ? "told, stored after all"
                                            : "told, unstored named");
    return std::move(verdict_);
  }

 private:
  std::string first_told() const {
    if (!run_.refused.empty()) return run_.refused;
    if (!run_.told.empty()) return run_.told.front().second;
    return run_.unstored.empty() ? "" : run_.unstored.front();
  }

  void keeps_what_was_stored() {
    const Before now(folder_);
    if (now.log != before_.log) verdict_.violate("the earlier log has changed");
    if (!now.results.starts_with(before_.results)) verdict_.violate("earlier results are lost");
    if (!now.flashes.starts_with(before_.flashes)) verdict_.violate("earlier flashes are lost");
  }

  /// The program has said that there is not enough memory, and ended.
  Verdict judge_unfinished() {
    keeps_what_was_stored();
    judge_log();
    if (run_.bench.armed()) verdict_.violate("left armed");
    verdict_.count("told, unstored named");
    verdict_.words = "not enough memory";
    return std::move(verdict_);
  }

  void judge_what_is_gone() {
    if (run_.unstored.empty()) verdict_.violate("what is gone is not named");
    if (run_.told.empty()) return verdict_.violate("what is gone was not told");
    if (run_.told.front().first > *run_.failed_at + std::chrono::seconds{1})
      verdict_.violate("told too late");
  }

  void judge_log() {
    if (!run_.refused.empty()) return;
    const fs::path path = folder_ / (std::string("host-") + kUtc + ".lcmlog");
    const Log log = read_log(path);
    const int lost = missing(run_.bench.messages(), log.messages);
    if (lost < 0) verdict_.violate("the log holds what never came");
    std::error_code error;
    const bool torn =
        (fs::exists(path, error) || !run_.out_of_memory) && fs::file_size(path, error) != log.bytes;
    if (torn && (run_.out_of_memory || !mentions(path.filename())))
      verdict_.violate("the log holds a torn record, untold");
    if (!run_.out_of_memory) lost_at(path.filename(), lost);
  }

  void judge_tables() {
    if (!run_.refused.empty()) return;
    const auto results = testing::read_csv(folder_ / "results.csv").rows;
    std::set<std::string> rows;  // by boot and shot
    for (auto i = static_cast<std::size_t>(std::ranges::count(before_.results, '\n')) - 1; i < results.size();
         ++i)
      if (results[i].size() > 2) rows.insert(results[i][1] + "," + results[i][2]);
    int lost = 0;
    for (const int shot : run_.results)
      lost += !rows.contains(fmt::format("{:x},{}", ScriptedBench::kBoot + 1, shot));
    lost_at("results.csv", lost);
    const std::string text = testing::read_text(folder_ / "flashes.csv");
    lost = 0;
    for (const auto& shot : run_.bench.shots()) lost += text.find(host::flashes_lines(shot)) == text.npos;
    lost_at("flashes.csv", lost);
    for (const char* table : {"results.csv", "flashes.csv"}) {
      const std::string all = testing::read_text(folder_ / table);
      const testing::CsvTable csv = testing::read_csv(folder_ / table);
      const bool torn = !all.empty() && all.back() != '\n';
      const bool uneven =
          std::ranges::any_of(csv.rows, [&csv](const auto& row) { return row.size() != csv.columns.size(); });
      if ((torn || uneven) && !mentions(table)) verdict_.violate("{} has a torn line, untold", table);
    }
  }

  bool mentions(const std::string& file) const {
    return std::ranges::any_of(run_.unstored,
                               [&](const std::string& line) { return line.find(file) != line.npos; });
  }

  /// So many records are missing in the file.
  void lost_at(const std::string& file, int lost) {
    if (lost <= 0) return;
    if (!mentions(file)) verdict_.violate("{}: {} records are lost and not named in the end", file, lost);
    const auto line = std::ranges::find_if(
        run_.told, [&](const auto& told) { return told.second.find(file) != told.second.npos; });
    if (line == run_.told.end()) return verdict_.violate("{}: a loss was not told", file);
    if (run_.failed_at && line->first > *run_.failed_at + std::chrono::seconds{1})
      verdict_.violate("{}: told too late", file);
  }

  void judge_words() {
    if (!run_.refused.empty()) {
      if (!run_.bench.fires().empty()) verdict_.violate("fired without a session");
      return;
    }
    if (!run_.finished) verdict_.violate("the series did not end");
    if (!run_.told.empty()) {
      for (const Duration fire : run_.bench.fires())
        if (fire > run_.told.front().first) verdict_.violate("fired after a failure was told");
    }
    const bool doubtful = fault_.error != EINTR && (fault_.call == "fsync" || fault_.call == "close");
    if (doubtful && testing::disk_faults_injected() > 0 && run_.unstored.empty())
      verdict_.violate("what may be lost is not named");
    const bool quiet = run_.told.empty() && run_.unstored.empty();
    if (quiet && !run_.succeeded) verdict_.violate("did not succeed, without a word");
    if (testing::disk_faults_injected() == 0 && !run_.taken_away && !quiet)
      verdict_.violate("told a failure that was none");
  }

  const fs::path& folder_;
  const testing::DiskFault& fault_;
  const Run& run_;
  const Before& before_;
  Verdict verdict_;
};

}  // namespace

Verdict run_session(const fs::path& folder, const testing::DiskFault& fault) {
  testing::clear_disk_fault();
  {
    Run first(0);
    fire(first, folder, kFirstUtc, 1, {});
    std::string words = first.refused;
    for (const auto& [when, line] : first.told) words += line + "; ";
    for (const std::string& line : first.unstored) words += line + "; ";
    if (!first.succeeded || !words.empty()) throw std::runtime_error("the run without a fault: " + words);
  }
  const Before before(folder);
  Run run(1);
  testing::set_disk_fault(fault);
  try {
    fire(run, folder, kUtc, kShots, fault);
  } catch (const std::bad_alloc&) {
    run.out_of_memory = true;
  }
  testing::clear_disk_fault();
  return Judge(folder, fault, run, before).verdict();
}

}  // namespace strobe::storage
