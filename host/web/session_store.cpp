#include "host/web/session_store.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "host/archive/read_session.hpp"
#include "host/series/select.hpp"
#include "host/session/session_logs.hpp"

namespace strobe::web {
namespace {

namespace fs = std::filesystem;
using host::Shot;
using host::StoredSession;
using nlohmann::ordered_json;

std::string log_sizes(const fs::path& folder) {
  std::string text;
  for (const auto& logs : {host::host_logs(folder), host::journals(folder)})
    for (const fs::path& log : logs)
      text += fmt::format("{}:{}/", log.filename().string(), stamp_of(log).bytes);
  return text;
}

std::set<ShotKey> keys_of(const std::vector<ShotRow>& rows) {
  std::set<ShotKey> keys;
  for (const ShotRow& row : rows) keys.insert(row.key);
  return keys;
}

const Shot* shot_of(const StoredSession& session, const ShotKey& key) {
  const auto found = std::ranges::find(session.shots, key, &Shot::key);
  return found == session.shots.end() ? nullptr : &*found;
}

/// Whether a shot's budget is that of another reading of it.
bool is_same_measurement(const Shot& a, const Shot& b) {
  return a.digitizations.size() == b.digitizations.size() && a.rejected == b.rejected &&
         (a.digitizations.empty() || a.digitizations.back().file == b.digitizations.back().file);
}

}  // namespace

bool SessionStore::is_live(const fs::path& folder) const {
  return !settings_.live.empty() && session_id(folder.filename().string()) == settings_.live;
}

SessionStore::Stamps SessionStore::stamps_of(const fs::path& folder) {
  return {stamp_of(folder / "results.csv"), stamp_of(folder / "runs.jsonl"), stamp_of(folder / "rig.toml")};
}

std::vector<ordered_json> SessionStore::list() {
  const std::lock_guard lock(mutex_);
  std::map<fs::path, Line> lines;
  std::vector<ordered_json> sessions;
  for (const fs::path& folder : session_folders(settings_.sessions)) {
    const Stamps stamps = stamps_of(folder);
    const auto known = lines_.find(folder);
    const bool holds = known != lines_.end() && known->second.stamps == stamps;
    sessions.push_back(holds ? known->second.json : session_json(read_table(folder), is_live(folder)));
    lines.emplace(folder, Line{stamps, sessions.back()});
  }
  lines_ = std::move(lines);
  std::ranges::stable_sort(sessions, std::greater{}, [](const ordered_json& session) {
    return session["utc"].is_string() ? session["utc"].get<std::string>() : std::string();
  });
  return sessions;
}

Answered<fs::path> SessionStore::folder(const std::string& id) const {
  auto folder = session_folder(settings_.sessions, id);
  if (!folder) return unanswered(404, "no session of this name is in the sessions' folder");
  return std::move(*folder);
}

std::shared_ptr<const SessionTable> SessionStore::table_of(const fs::path& folder) {
  const Stamps now = stamps_of(folder);
  if (const Table* known = tables_.find(folder); known != nullptr && known->stamps == now)
    return known->table;
  return tables_.put(folder, {now, std::make_shared<const SessionTable>(read_table(folder))}, 1).table;
}

Answered<SessionStore::Stored*> SessionStore::read(const fs::path& folder) {
  // Their state first: what changes meanwhile is read again.
  const std::string edits = edits_of(folder).state, logs = log_sizes(folder);
  std::set<ShotKey> told = keys_of(table_of(folder)->rows);
  ++readings_;
  auto session = host::read_session(folder, {.rig_path = "", .key_file = settings_.key_file, .progress = {}});
  if (!session) return unanswered(409, session.error().message);
  Stored read{std::make_shared<const StoredSession>(std::move(*session)), edits, std::move(told), logs, {}};
  if (Stored* before = stored_.find(folder)) {
    for (auto& [key, made] : before->budgets) {
      const Shot *old = shot_of(*before->session, key), *shot = shot_of(*read.session, key);
      if (old != nullptr && shot != nullptr && is_same_measurement(*old, *shot))
        read.budgets.emplace(key, std::move(made));
    }
  }
  const std::size_t cost = read.session->shots.size() + 1;
  return &stored_.put(folder, std::move(read), cost);
}

/// A host that writes moves its log twice a second: what was read holds for the shots that results.csv had by
/// then.
Answered<SessionStore::Stored*> SessionStore::stored_with(const fs::path& folder,
                                                          const std::set<ShotKey>& needed) {
  Stored* known = stored_.find(folder);
  if (known == nullptr || known->edits != edits_of(folder).state) return read(folder);
  if (std::ranges::includes(known->told, needed)) return known;
  return known->logs == log_sizes(folder) ? Answered<Stored*>(known) : read(folder);
}

Answered<std::vector<ShotRow>> SessionStore::rows_of(const fs::path& folder) {
  const auto table = table_of(folder);
  std::vector<ShotRow> rows = table->rows;
  const Edits edits = edits_of(folder);
  const bool has_logs = !host::host_logs(folder).empty() || !host::journals(folder).empty();
  if (rows.empty() && has_logs && !is_live(folder)) {
    const auto stored = stored_with(folder, {});
    if (!stored) return tl::unexpected(stored.error());
    for (const Shot& shot : (*stored)->session->shots) rows.push_back(shot_row(shot));
    return rows;
  }
  if (rows.empty() && !table->problem.empty()) return unanswered(409, table->problem);
  std::set<ShotKey> edited;
  for (const ShotRow& row : rows)
    if (edits.shots.contains(row.key)) edited.insert(row.key);
  if (edited.empty()) return rows;
  const auto stored = stored_with(folder, edited);
  if (!stored) return tl::unexpected(stored.error());
  for (ShotRow& row : rows) {
    const Shot* shot = edited.contains(row.key) ? shot_of(*(*stored)->session, row.key) : nullptr;
    if (shot == nullptr) continue;
    std::string name = std::move(row.name);
    row = shot_row(*shot);
    row.name = std::move(name);
  }
  return rows;
}

Answered<std::vector<ShotRow>> SessionStore::rows(const std::string& id) {
  const auto path = folder(id);
  if (!path) return tl::unexpected(path.error());
  const std::lock_guard lock(mutex_);
  return rows_of(*path);
}

std::optional<ShotKey> SessionStore::key_of(const fs::path& folder, const std::string& name) {
  const auto table = table_of(folder);
  const auto row = std::ranges::find(table->rows, name, &ShotRow::name);
  return row == table->rows.end() ? std::nullopt : std::optional(row->key);
}

std::shared_ptr<const Shot> SessionStore::live_shot(const fs::path& folder, const std::string& name) {
  if (live_shots_ == nullptr || !is_live(folder)) return nullptr;
  auto key = key_of(folder, name);
  if (!key) {  // its row is not on the disk yet
    for (int digits = 0; const char c : name)
      if (c < '0' || c > '9' || ++digits > 9) return nullptr;
    key = live_shots_->newest_numbered(std::stoi("0" + name));
  }
  if (!key || edits_of(folder).shots.contains(*key)) return nullptr;
  auto shot = live_shots_->find(*key);
  if (!shot) return nullptr;
  shot->name = name;
  const auto table = table_of(folder);
  const auto row = std::ranges::find(table->rows, *key, &ShotRow::key);
  if (row != table->rows.end()) shot->utc = row->utc;
  if (!shot->digitizations.empty()) shot->digitizations.back().utc = shot->utc;
  return std::make_shared<const Shot>(std::move(*shot));
}

Answered<ShotOfSession> SessionStore::shot(const std::string& id, const std::string& name) {
  const auto path = folder(id);
  if (!path) return tl::unexpected(path.error());
  {
    const std::lock_guard lock(mutex_);
    if (auto live = live_shot(*path, name)) return ShotOfSession{nullptr, std::move(live)};
  }
  return stored_shot(id, name);
}

Answered<ShotOfSession> SessionStore::stored_shot(const std::string& id, const std::string& name) {
  const auto path = folder(id);
  if (!path) return tl::unexpected(path.error());
  const std::lock_guard lock(mutex_);
  const auto key = key_of(*path, name);
  const auto stored = stored_with(*path, key ? std::set{*key} : std::set<ShotKey>{});
  if (!stored) return tl::unexpected(stored.error());
  const Session& session = (*stored)->session;
  const auto found = key ? std::ranges::find(session->shots, *key, &Shot::key)
                         : std::ranges::find(session->shots, name, &Shot::name);
  if (found == session->shots.end()) return unanswered(404, "the session has no shot of this name");
  return ShotOfSession{session, std::shared_ptr<const Shot>(session, &*found)};
}

Answered<std::shared_ptr<const StoredSession>> SessionStore::stored(const std::string& id) {
  const auto path = folder(id);
  if (!path) return tl::unexpected(path.error());
  const std::lock_guard lock(mutex_);
  const auto stored = stored_with(*path, keys_of(table_of(*path)->rows));
  if (!stored) return tl::unexpected(stored.error());
  return (*stored)->session;
}

Answered<std::vector<host::Shot>> SessionStore::series_shots(const std::string& id) {
  const auto path = folder(id);
  if (!path) return tl::unexpected(path.error());
  const std::lock_guard lock(mutex_);
  const auto stored = stored_with(*path, keys_of(table_of(*path)->rows));
  if (!stored) return tl::unexpected(stored.error());
  auto& budgets = (*stored)->budgets;
  std::vector<host::Shot> shots;
  for (const Shot& shot : (*stored)->session->shots) {
    auto made = budgets.find(shot.key());
    if (made == budgets.end()) made = budgets.emplace(shot.key(), host::series_shot(shot)).first;
    shots.push_back(made->second);
  }
  return shots;
}

void SessionStore::take_change(const std::string& id, const Shot& shot) {
  const auto path = folder(id);
  if (!path) return;
  const std::lock_guard lock(mutex_);
  Stored* known = stored_.find(*path);
  if (known == nullptr) return;
  auto session = std::make_shared<StoredSession>(*known->session);
  const auto place = std::ranges::find(session->shots, shot.key(), &Shot::key);
  if (place == session->shots.end()) return;
  *place = shot;
  known->session = std::move(session);
  known->edits = edits_of(*path).state;
  known->budgets.erase(shot.key());
}

Answered<std::string> SessionStore::state(const std::string& id) {
  const auto path = folder(id);
  if (!path) return tl::unexpected(path.error());
  const Stamps now = stamps_of(*path);
  return fmt::format("{} {} {} {} {}{}", now.results.bytes, now.results.changed, now.rig.bytes,
                     now.rig.changed, edits_of(*path).state, is_live(*path) ? "" : log_sizes(*path));
}

}  // namespace strobe::web
