#include "host/archive/read_session.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <set>
#include <system_error>

#include "common/config/files.hpp"
#include "host/archive/log_player.hpp"
#include "host/archive/redigitize.hpp"
#include "host/archive/session_files.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/session/run_record.hpp"
#include "host/session/session_folder.hpp"
#include "host/session/session_logs.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

constexpr double kLogsShare = 0.95;            // of the work, as a share
constexpr std::int64_t kProgressEvery = 2000;  // messages

class SessionReader {
 public:
  SessionReader(const fs::path& folder, const ReadSessionOptions& options, SessionRigs rigs)
      : options_(options), rigs_(std::move(rigs)) {
    session_.folder = folder;
    session_.rig = *rigs_.main();
    session_.logs = host_logs(folder);
  }

  Result<StoredSession> read() {
    auto plan = config::read_file_if_any(session_.folder / "plan.toml");
    if (!plan) return tl::unexpected(plan.error());
    session_.plan_text = std::move(*plan).value_or("");
    auto runs = read_runs(session_.folder / "runs.jsonl");
    if (!runs) return tl::unexpected(runs.error());
    const auto key = sealing_key();
    session_.verified = key.has_value() && !session_.logs.empty();
    if (auto played = play(key); !played) return tl::unexpected(played.error());
    find_runs(std::move(*runs));
    find_shots();
    if (auto found = find_digitizations(); !found) return tl::unexpected(found.error());
    find_photographs();
    name_shots();
    progress(1.0);
    return std::move(session_);
  }

 private:
  void remark(std::string text) { session_.remarks.push_back(std::move(text)); }
  void progress(double share) const {
    if (options_.progress) options_.progress(share);
  }

  std::optional<authentication::Key> sealing_key();
  Result<void> play(const std::optional<authentication::Key>& key);
  void find_runs(RunRecords records);
  void add_unrecorded_run(std::int64_t host, WallTime time);
  const SessionRigs::Rig& rig_of(std::int64_t host_id) const;
  std::string until_known_of(std::int64_t host_id) const;
  bool own(const LoggedShot& fired) const;
  void find_shots();
  Shot stored(const ShotKey& key, const LoggedShot& fired) const;
  Result<void> find_digitizations();
  void find_photographs();
  void name_shots();

  const ReadSessionOptions& options_;
  SessionRigs rigs_;
  StoredSession session_;
  std::optional<LogPlayer> player_;
  std::optional<FiredShots> fired_;  ///< listens to the player
  std::map<std::int64_t, fs::path> log_of_host_;
  std::set<std::int64_t> own_hosts_;
};

/// The key, if every log is sealed with it.
std::optional<authentication::Key> SessionReader::sealing_key() {
  const auto key = rigs_.key(options_.key_file);
  if (!key) {
    remark("unverified: this host has no key of a lab that it can read (see strobe key)");
    return std::nullopt;
  }
  for (const fs::path& log : session_.logs) {
    if (is_sealed(log, session_.rig.rig, *key).value_or(true)) continue;
    remark(fmt::format("unverified: {} has no seal of this host's key (see strobe key)",
                       log.filename().string()));
    return std::nullopt;
  }
  return key;
}

/// The hosts' logs, then what these lack of the journals.
Result<void> SessionReader::play(const std::optional<authentication::Key>& key) {
  auto logs = StoredLogs::open(session_.logs);
  if (!logs) return tl::unexpected(logs.error());
  player_.emplace(session_.rig, key);
  fired_.emplace(*player_, session_.rig.rig);
  player_->play(*logs, [&](const LogMessage& message) {
    fired_->watch(message);
    if (logs->messages() % kProgressEvery == 0) progress(kLogsShare * logs->share());
  });
  for (std::string& text : logs->remarks()) remark(std::move(text));
  for (const auto& [host, heard] : fired_->commanding_hosts()) log_of_host_[host] = logs->path(heard.log);
  fired_->begin_journals();
  for (const fs::path& path : journals(session_.folder)) {
    auto journal = StoredLogs::open({path});
    if (!journal) return tl::unexpected(journal.error());
    player_->complete_from(*journal, *fired_);
    for (std::string& text : journal->remarks()) remark(std::move(text));
  }
  player_->end();
  return {};
}

void SessionReader::find_runs(RunRecords records) {
  session_.runs = std::move(records.runs);
  for (std::string& told : records.remarks) remark(std::move(told));
  const bool nobody = fired_->commanding_hosts().empty() && session_.runs.empty();
  for (const auto& [host, heard] : nobody ? fired_->reading_hosts() : fired_->commanding_hosts())
    add_unrecorded_run(host, heard.time);
  std::ranges::stable_sort(session_.runs, {}, &RunRecord::utc);
  for (const RunRecord& run : session_.runs) own_hosts_.insert(run.host_id);
  if (own_hosts_.empty())
    remark("no run of strobe fire is known here: every shot is taken for the session's own");
}

/// Of a version that kept no runs, or whose record of it was lost.
void SessionReader::add_unrecorded_run(std::int64_t host, WallTime time) {
  if (std::ranges::any_of(session_.runs, [host](const RunRecord& run) { return run.host_id == host; }))
    return;
  RunRecord run;
  run.host_id = host;
  run.utc = utc_for_table(time);
  session_.runs.push_back(std::move(run));
}

std::string SessionReader::until_known_of(std::int64_t host_id) const {
  const auto run = std::ranges::find(session_.runs, host_id, &RunRecord::host_id);
  return run == session_.runs.end() ? "" : run->until_known;
}

const SessionRigs::Rig& SessionReader::rig_of(std::int64_t host_id) const {
  const auto log = log_of_host_.find(host_id);
  return log == log_of_host_.end() ? rigs_.main() : rigs_.of_log(log->second);
}

/// A shot of nobody known is rather kept than lost.
bool SessionReader::own(const LoggedShot& fired) const {
  return own_hosts_.empty() || fired.host_id == 0 || own_hosts_.contains(fired.host_id);
}

void SessionReader::find_shots() {
  int foreign = 0;
  int lost = 0;
  std::vector<std::pair<WallTime, ShotKey>> order;
  for (const auto& [key, fired] : fired_->all()) {
    if (fired.dry) continue;
    if (!own(fired)) {
      ++foreign;
      continue;
    }
    lost += fired.from_journal ? 1 : 0;
    order.emplace_back(fired_->boots().at(key.boot_id), key);
  }
  std::ranges::sort(order);
  for (const auto& [boot_heard, key] : order) session_.shots.push_back(stored(key, fired_->all().at(key)));
  if (foreign > 0)
    remark(fmt::format("{} shot{} of other hosts {} left out", foreign, foreign == 1 ? "" : "s",
                       foreign == 1 ? "is" : "are"));
  if (lost > 0) {
    session_.verified = false;
    remark(fmt::format(
        "the summar{} of {} shot{} come{} from strobed's journal, which has no seal: no host's log has {}",
        lost == 1 ? "y" : "ies", lost, lost == 1 ? "" : "s", lost == 1 ? "s" : "",
        lost == 1 ? "it" : "them"));
  }
}

Shot SessionReader::stored(const ShotKey& key, const LoggedShot& fired) const {
  Shot shot = logged_outcome(key, fired);
  shot.summary = fired.summary;
  shot.rig = rig_of(fired.host_id);
  shot.until_known = until_known_of(fired.host_id);
  shot.verified = session_.verified && !fired.from_journal;
  const LoggedFrame* late = fired_->late_frame(key);
  if (late != nullptr) shot.digitizations = {{late->frame, late->frame.source == "hand", "", "", {}, {}}};
  WallTime came = fired.heard;
  if (shot.frame() != nullptr) {
    if (const LoggedFrame* logged = fired_->frame(key)) came = std::max(came, logged->time);
    shot.digitizations.back().utc = utc_for_table(came);
  }
  shot.utc = utc_for_table(came);
  const bool other_rig = shot.rig != rigs_.main();
  if (late != nullptr || (other_rig && shot.frame() != nullptr)) judge_again(shot);
  return shot;
}

Result<void> SessionReader::find_digitizations() {
  const auto files = digitization_files(session_.folder);
  if (!files) return tl::unexpected(files.error());
  for (Shot& shot : session_.shots) {
    const auto found = files->find(shot.key());
    if (found == files->end()) continue;
    for (const DigitizationFile& file : found->second) {
      if (auto digitization = read_digitization(file))
        shot.digitizations.push_back(std::move(*digitization));
      else
        remark(digitization.error().message);
    }
    if (!shot.digitizations.empty() && !shot.digitizations.back().file.empty()) judge_again(shot);
  }
  return {};
}

void SessionReader::find_photographs() {
  std::set<fs::path> named;
  for (Shot& shot : session_.shots) {
    for (const Digitization& digitization : shot.digitizations)
      if (auto path = named_photograph(session_.folder, digitization.frame.photograph))
        shot.photograph = path;
    if (shot.photograph) named.insert(*shot.photograph);
  }
  // Dry shots and other hosts' have photographs, too.
  std::vector<ShotKey> without;
  for (const auto& [key, fired] : fired_->all()) {
    const auto* frame = fired.result ? fired.result->frame() : nullptr;
    const auto measured = frame ? named_photograph(session_.folder, frame->photograph) : std::nullopt;
    if (measured) named.insert(*measured);
    const auto shot = std::ranges::find(session_.shots, key, &Shot::key);
    const bool has = shot != session_.shots.end() ? shot->photograph.has_value() : measured.has_value();
    if (!has) without.push_back(key);
  }
  UnnamedPhotographs unnamed = unnamed_photographs(session_.folder, named, without);
  for (Shot& shot : session_.shots) {
    if (const auto found = unnamed.of_shot.find(shot.key()); found != unnamed.of_shot.end())
      shot.photograph = found->second;
  }
  for (std::string& told : unnamed.remarks) remark(std::move(told));
}

void SessionReader::name_shots() {
  std::vector<ShotKey> keys;
  for (const Shot& shot : session_.shots) keys.push_back(shot.key());
  std::vector<std::string> names = shot_names(keys);
  std::vector<std::string> without_end;
  for (std::size_t i = 0; i < names.size(); ++i) {
    session_.shots[i].name = names[i];
    if (!session_.shots[i].summary) without_end.push_back(names[i]);
  }
  if (without_end.empty()) return;
  remark(fmt::format("the end of shot{} {} is in no log", without_end.size() == 1 ? "" : "s",
                     fmt::join(without_end, ", ")));
  session_.advice.emplace_back("if strobed kept its journal in another folder, copy it into the session's");
}

/// Times as the session's results.csv has them.
Result<void> take_times(StoredSession& session) {
  auto rows = read_results_rows(session.folder / "results.csv");
  if (!rows) return tl::unexpected(rows.error());
  std::map<ShotKey, std::string> times;
  for (ResultsRow& row : *rows) times.try_emplace(row.key, std::move(row.utc));
  for (Shot& shot : session.shots)
    if (const auto found = times.find(shot.key()); found != times.end()) shot.utc = found->second;
  return {};
}

}  // namespace

Result<StoredSession> read_session(const fs::path& folder, const ReadSessionOptions& options) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return fail(folder.string() + ": no such folder of a session");
  const auto logs = host_logs(folder);
  if (logs.empty() && journals(folder).empty())
    return fail(folder.string() +
                ": no log of a host (host-*.lcmlog) and no journal (journal-*.lcmlog) is in it");
  auto rigs = SessionRigs::open(folder, options.rig_path, logs);
  if (!rigs) return tl::unexpected(rigs.error());
  auto session = SessionReader(folder, options, std::move(*rigs)).read();
  if (!session) return session;
  if (auto taken = take_times(*session); !taken) return tl::unexpected(taken.error());
  if (auto remark = never_digitized_remark(*session)) {
    session->remarks.push_back(std::move(*remark));
    session->advice.push_back(completion_advice(*session));
  }
  return session;
}

Result<const Shot*> find_shot(const StoredSession& session, const std::string& name) {
  const auto found = std::ranges::find(session.shots, name, &Shot::name);
  if (found != session.shots.end()) return &*found;
  std::vector<std::string> names;
  for (const Shot& shot : session.shots) names.push_back(shot.name);
  if (names.empty()) return fail(fmt::format("{}: no shot was fired", session.folder.string()));
  return fail(fmt::format("{}: no shot {}; there {}: {}", session.folder.string(), name,
                          names.size() == 1 ? "is" : "are", fmt::join(names, ", ")));
}

}  // namespace strobe::host
