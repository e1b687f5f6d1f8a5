#include "tests/campaigns/storage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <new>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

#include "common/authentication/key_file.hpp"
#include "common/config/files.hpp"
#include "host/loop/series_runner.hpp"
#include "host/session/shot_table.hpp"
#include "host/session/run_lock.hpp"
#include "tests/campaigns/scripted_bench.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::storage {
namespace {

namespace fs = std::filesystem;
using campaigns::Verdict;
using testing::DiskFault;

constexpr std::array kErrors{ENOSPC, EROFS, EDQUOT, EIO, ESTALE, EFBIG, EMFILE};

/// Where and when: which calls there are, how many of them are made, and how often of the rest they are drawn.
struct Place {
  const char* file;
  const char* call;
  int calls;
  int weight = 1;
};
// A series of three shots.
const std::vector<Place> kSessionPlaces{{"host-20260131T10", "write", 120, 3},
                                        {"host-20260131T10", "fsync", 4},
                                        {"host-20260131T10", "close", 1},
                                        {"host-20260131T10", "open", 1},
                                        {"results.csv", "write", 3, 2},
                                        {"results.csv", "fsync", 4},
                                        {"results.csv", "close", 1},
                                        {"results.csv", "open", 1},
                                        {"session.lock", "flock", 1},
                                        {"flashes.csv", "write", 3, 2},
                                        {"flashes.csv", "fsync", 4},
                                        {"flashes.csv", "close", 1},
                                        {"flashes.csv", "open", 1},
                                        {"", "fsync", 14},
                                        {"", "memory", 20'000, 2},
                                        {"", "remove folder", 14},
                                        {"", "rename folder", 14},
                                        {"results.csv", "remove file", 14},
                                        {"host-20260131T100000Z.lcmlog", "remove file", 14},
                                        {"", "write", 130, 2},
                                        {"", "open", 4}};
const std::vector<Place> kFilePlaces{
    {"", "write", 3}, {"", "fsync", 2}, {"", "close", 2}, {"", "rename", 1}, {"", "open", 1}};
const std::vector<Place> kKeyPlaces{{"", "write", 1}, {"", "fsync", 2}, {"", "close", 2}, {"", "link", 1}};

constexpr std::array kEndings{"not reached", "harmless", "refused", "told, stored after all",
                              "told, unstored named"};

const std::string kOld(3'000'000, 'o');
const std::string kNew(2'500'000, 'n');

/// Of a file written in one go: told is what the writer said, empty if it is stored.
Verdict judge_file(const fs::path& path, const std::string& told, const std::string& before,
                   const std::string& wanted) {
  Verdict verdict;
  const std::string now = testing::read_text(path);
  if (told.empty() && now != wanted) verdict.violate("told as stored, and is not");
  if (now != before && now != wanted) verdict.violate("neither the old file nor the new one");
  if (!told.empty() && told.find(path.filename().string()) == told.npos)
    verdict.violate("the file is not named");
  for (const auto& entry : fs::directory_iterator(path.parent_path()))
    if (entry.path().extension() == ".new") verdict.violate("a draft is left over");
  verdict.words = told;
  const bool reached = testing::disk_faults_injected() > 0;
  verdict.count(!reached        ? "not reached"
                : told.empty()  ? "harmless"
                : now == wanted ? "told, stored after all"
                                : "refused");
  if (!reached && !told.empty()) verdict.violate("told a failure that was none");
  return verdict;
}

/// What the function returns, with the disk at fault meanwhile.
template <typename Function>
auto with_fault(const DiskFault& fault, const Function& function) {
  testing::set_disk_fault(fault);
  auto result = function();
  testing::clear_disk_fault();
  return result;
}

Verdict run_replaced(const fs::path& path, const DiskFault& fault) {
  testing::write_text(path, kOld);
  const auto written = with_fault(fault, [&] { return config::write_file(path, kNew); });
  return judge_file(path, testing::error_of(written), kOld, kNew);
}

Verdict run_copied(const fs::path& path, const DiskFault& fault) {
  const fs::path from = path.parent_path() / "exposure.tif";
  testing::write_text(from, kNew);
  const auto copied = with_fault(fault, [&] { return config::copy_file(from, path); });
  return judge_file(path, testing::error_of(copied), "", kNew);
}

Verdict run_key(const fs::path& path, const DiskFault& fault) {
  const auto made = with_fault(fault, [&] { return authentication::make_key_file(path); });
  const bool readable = authentication::read_key_file(path).has_value();
  const std::string wanted = made ? made->key.text() + "\n" : readable ? testing::read_text(path) : "a key";
  Verdict verdict = judge_file(path, testing::error_of(made), "", wanted);
  if (made && !readable) verdict.violate("the key cannot be read");
  return verdict;
}

Verdict run_target(const std::string& target, const fs::path& folder, const DiskFault& fault) {
  if (target == "replaced file") return run_replaced(folder / "camera.toml", fault);
  if (target == "copied file") return run_copied(folder / "shot-0001-exposure.tif", fault);
  if (target == "key") return run_key(folder / "lab.key", fault);
  fs::create_directory(folder / "session");
  return run_session(folder / "session", fault);
}

/// File, call and error. Memory that is refused and files that are taken away have no errno.
std::string row_of(const Trial& trial) {
  const DiskFault& fault = trial.fault;
  const std::string of_session = fault.file.empty() ? "any of a session" : fault.file;
  const bool is_error = fault.call != "memory" && fault.call.find(' ') == fault.call.npos;
  return fmt::format("{}, {}{}", trial.target == "session" ? of_session : trial.target, fault.call,
                     is_error ? fmt::format(" {}", strerrorname_np(fault.error)) : "");
}

const Place& place_of(campaigns::Draws& draws, const std::vector<Place>& places) {
  std::vector<int> weights;
  for (const Place& place : places) weights.push_back(place.weight);
  return places[static_cast<std::size_t>(draws.weighted(weights))];
}

}  // namespace

Trial drawn(campaigns::Draws draws) {
  Trial trial;
  const int kind = draws.between(0, 9);
  trial.target = kind < 7 ? "session" : kind == 7 ? "replaced file" : kind == 8 ? "copied file" : "key";
  const Place& place = place_of(draws, kind < 7 ? kSessionPlaces : kind < 9 ? kFilePlaces : kKeyPlaces);
  DiskFault& fault = trial.fault;
  fault.file = place.file;
  fault.call = place.call;
  fault.nth = draws.between(1, place.calls);
  fault.times = draws.choice(std::array{1, 1, 2, 5, 20, 1'000'000});
  fault.error = draws.choice(kErrors);
  if (fault.call == "write" && draws.between(0, 3) == 0) fault.error = EINTR;
  if (fault.error == EINTR && fault.times > 20) fault.times = 20;  // for ever, no program would come back
  if (fault.call == "write" && draws.chance(0.5)) fault.short_bytes = draws.between(1, 400);
  fault.truncate_too = fault.call == "write" && draws.between(0, 2) == 0;
  return trial;
}

Verdict run_trial(Trial trial) {
  const testing::TemporaryFolder folder;
  trial.fault.folder = folder.path().string();
  Verdict verdict = run_target(trial.target, folder.path(), trial.fault);
  verdict.trial = fmt::format("{}, {}, told: \"{}\"", trial.target, to_text(trial.fault), verdict.words);
  verdict.rows = {{"file, call, error", row_of(trial)}};
  for (const char* ending : kEndings) verdict.count(ending, 0.0);
  return verdict;
}

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
  void on_shot_result(const host::Shot& result) override { results.push_back(result.shot_id); }

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
