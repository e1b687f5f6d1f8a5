// The sessions below a folder, for whoever looks at them: lists by their small files, details by their logs,
// each read once and kept as long as it holds. Reads files; writes none. Thread-safe, one reading at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "host/archive/read_session.hpp"
#include "host/series/series.hpp"
#include "host/web/bounded_cache.hpp"
#include "host/web/http/message.hpp"
#include "host/web/live_shots.hpp"
#include "host/web/session_folders.hpp"
#include "host/web/session_table.hpp"

namespace strobe::web {

struct SessionStoreSettings {
  std::filesystem::path sessions;  ///< the folder that holds them
  std::string live;                ///< id of the one that this process writes; empty: none
  std::string key_file;            ///< as of --key-file
  std::string version;             ///< of strobe, for reports
};

/// A shot, and the session that it was read with; null: the shot is so new that only this process knows it
/// whole.
struct ShotOfSession {
  std::shared_ptr<const host::StoredSession> session;
  std::shared_ptr<const host::Shot> shot;
};

class SessionStore {
 public:
  explicit SessionStore(SessionStoreSettings settings) : settings_(std::move(settings)) {}

  const SessionStoreSettings& settings() const { return settings_; }
  /// Before the first request; must outlive the store. Null: none.
  void set_live_shots(const LiveShots* shots) { live_shots_ = shots; }

  /// Newest first.
  std::vector<nlohmann::ordered_json> list();

  /// Of all others: 404 where there is no such session or shot.
  Answered<std::filesystem::path> folder(const std::string& id) const;
  /// All shots in the order of their results, corrected ones as they are now.
  Answered<std::vector<ShotRow>> rows(const std::string& id);
  Answered<ShotOfSession> shot(const std::string& id, const std::string& name);
  /// Likewise, always with its session: what a correction needs.
  Answered<ShotOfSession> stored_shot(const std::string& id, const std::string& name);
  /// With every shot that results.csv has.
  Answered<std::shared_ptr<const host::StoredSession>> stored(const std::string& id);
  /// The session's shots with their budgets, each made once.
  Answered<std::vector<host::Shot>> series_shots(const std::string& id);

  /// A shot of the session was corrected, or that taken back: what was read stays, with the shot as it is
  /// now.
  void take_change(const std::string& id, const host::Shot& shot);

  /// A state of the session's shots: the same text, the same numbers.
  Answered<std::string> state(const std::string& id);

  /// How often logs were read: for tests.
  int readings() const { return readings_; }

  static constexpr std::size_t kMaxTables = 8;
  static constexpr std::size_t kMaxStoredShots = 4000;  ///< of all sessions that are kept

 private:
  /// Of the small files that a list is made of.
  struct Stamps {
    FileStamp results, runs, rig;
    bool operator==(const Stamps&) const = default;
  };
  static Stamps stamps_of(const std::filesystem::path& folder);
  struct Table {
    Stamps stamps;
    std::shared_ptr<const SessionTable> table;
  };
  struct Stored {
    std::shared_ptr<const host::StoredSession> session;
    std::string edits;
    std::set<ShotKey> told;  ///< shots that results.csv had when the logs were read
    std::string logs;        ///< their sizes
    std::map<ShotKey, host::Shot> budgets;
  };
  using Session = std::shared_ptr<const host::StoredSession>;

  std::shared_ptr<const SessionTable> table_of(const std::filesystem::path& folder);
  Answered<Stored*> stored_with(const std::filesystem::path& folder, const std::set<ShotKey>& needed);
  Answered<Stored*> read(const std::filesystem::path& folder);
  Answered<std::vector<ShotRow>> rows_of(const std::filesystem::path& folder);
  std::optional<ShotKey> key_of(const std::filesystem::path& folder, const std::string& name);
  std::shared_ptr<const host::Shot> live_shot(const std::filesystem::path& folder, const std::string& name);
  bool is_live(const std::filesystem::path& folder) const;

  SessionStoreSettings settings_;
  const LiveShots* live_shots_ = nullptr;
  mutable std::mutex mutex_;
  BoundedCache<std::filesystem::path, Table> tables_{kMaxTables};
  BoundedCache<std::filesystem::path, Stored> stored_{kMaxStoredShots};
  struct Line {
    Stamps stamps;
    nlohmann::ordered_json json;
  };
  std::map<std::filesystem::path, Line> lines_;  ///< of the sessions that the last list had
  int readings_ = 0;
};

}  // namespace strobe::web
