// A batch under way: sessions are read and photographs measured by several threads, each row is stored as it
// is finished, each session's table once all its rows are. Reads and writes files; run() blocks; stop() may
// be called by any thread.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/batch/batch_row.hpp"
#include "host/batch/batch_tables.hpp"

namespace strobe::host {

struct BatchProgress {
  std::int64_t rows = 0;      ///< finished, those of earlier runs included
  std::int64_t measured = 0;  ///< of them in this run
  std::int64_t failed = 0;    ///< photographs that could not be measured, of any run
  int sessions = 0;           ///< finished, those that could not be read included
  int unread_sessions = 0;    ///< that could not be read
  int sessions_with_remarks = 0;
};

struct FinishedRow {
  std::string session;
  const Shot* shot = nullptr;  ///< null: of a session that cannot be read
  std::string line;            ///< of the table, without its line end
  bool failed = false;
  bool earlier = false;  ///< finished in an earlier run
};

class BatchRun {
 public:
  /// Called by one thread at a time.
  using Listener = std::function<void(const FinishedRow&, const BatchProgress&)>;

  BatchRun(const BatchSettings& settings, std::string id, std::filesystem::path out, BatchJournal& journal,
           Listener listener);
  ~BatchRun();

  /// Returns once all sessions are finished, or the photographs under way after stop(). Fails with the file
  /// that cannot be written.
  Result<BatchProgress> run(const std::vector<BatchSession>& sessions, int jobs);
  /// Safe in a signal's handler.
  void stop() { stopped_ = true; }
  bool stopped() const { return stopped_; }

 private:
  struct OpenSession;
  struct Task {
    std::shared_ptr<OpenSession> session;
    std::size_t shot = 0;
  };

  void work();
  bool take(Task& task, std::optional<BatchSession>& to_read);
  void read(const BatchSession& session);
  Result<std::shared_ptr<OpenSession>> open(const BatchSession& session) const;
  void measure(const Task& task);
  BatchRow row_of(const BatchShot& job, std::string& key, bool& earlier);
  void finish(const Task& task, const BatchRow& row, const std::string& key, bool earlier);
  void finish_unread(const BatchSession& session, const std::string& why);
  void finish_session(const OpenSession& session);
  void give_up(const std::string& problem);

  const BatchSettings& settings_;
  std::string id_;
  std::filesystem::path out_;
  BatchJournal& journal_;
  Listener listener_;
  std::atomic<bool> stopped_ = false;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<BatchSession> unread_;
  std::deque<Task> tasks_;
  int reading_ = 0;  ///< threads that read a session, which may give tasks
  BatchProgress progress_;
  std::string problem_;
};

}  // namespace strobe::host
