#include "host/batch/batch_run.hpp"

#include <fmt/format.h>

#include <exception>
#include <opencv2/core/utility.hpp>
#include <thread>
#include <utility>

#include "common/data/csv.hpp"
#include "host/archive/read_session.hpp"
#include "host/session/record_file.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {

struct BatchRun::OpenSession {
  BatchSession place;
  StoredSession stored;
  std::vector<std::string> lines;  ///< of the table, by shot
  std::size_t left = 0;            ///< shots that are not finished
};

BatchRun::BatchRun(const BatchSettings& settings, std::string id, std::filesystem::path out,
                   BatchJournal& journal, Listener listener)
    : settings_(settings),
      id_(std::move(id)),
      out_(std::move(out)),
      journal_(journal),
      listener_(std::move(listener)) {}

BatchRun::~BatchRun() = default;

Result<BatchProgress> BatchRun::run(const std::vector<BatchSession>& sessions, int jobs) {
  cv::setNumThreads(1);  // threads are one a photograph
  unread_.assign(sessions.begin(), sessions.end());
  std::vector<std::jthread> threads;
  for (int i = 0; i < jobs; ++i) threads.emplace_back([this] { work(); });
  threads.clear();
  if (!problem_.empty()) return fail(problem_);
  return progress_;
}

void BatchRun::give_up(const std::string& problem) {
  const std::lock_guard lock(mutex_);
  if (problem_.empty()) problem_ = problem;
  stopped_ = true;
  changed_.notify_all();
}

/// Photographs first, so that few sessions are open at once. Returns false if there is nothing more.
bool BatchRun::take(Task& task, std::optional<BatchSession>& to_read) {
  std::unique_lock lock(mutex_);
  while (!stopped_) {
    if (!tasks_.empty()) {
      task = std::move(tasks_.front());
      tasks_.pop_front();
      return true;
    }
    if (!unread_.empty()) {
      to_read = std::move(unread_.front());
      unread_.pop_front();
      ++reading_;
      return true;
    }
    if (reading_ == 0) return false;
    changed_.wait_for(lock, std::chrono::milliseconds(100));  // a signal's handler cannot wake it
  }
  return false;
}

void BatchRun::work() try {
  while (true) {
    Task task;
    std::optional<BatchSession> to_read;
    if (!take(task, to_read)) return;
    if (to_read)
      read(*to_read);
    else
      measure(task);
  }
} catch (const std::exception& error) {
  give_up(error.what());
}

Result<std::shared_ptr<BatchRun::OpenSession>> BatchRun::open(const BatchSession& session) const {
  auto stored = read_session(session.path, {.rig_path = settings_.rig, .key_file = {}, .progress = {}});
  if (!stored) return tl::unexpected(stored.error());
  auto open = std::make_shared<OpenSession>();
  open->place = session;
  open->stored = std::move(*stored);
  open->left = open->stored.shots.size();
  open->lines.resize(open->left);
  std::map<std::shared_ptr<const RigFile>, std::shared_ptr<const RigFile>> rigs;
  for (Shot& shot : open->stored.shots) {
    auto& rig = rigs[shot.rig];
    if (!rig) {
      auto own = calibrated(*shot.rig, settings_);
      if (!own) return tl::unexpected(own.error());
      rig = std::make_shared<const RigFile>(std::move(*own));
    }
    shot.rig = rig;
  }
  return open;
}

void BatchRun::read(const BatchSession& session) {
  auto opened = open(session);
  const std::lock_guard lock(mutex_);
  --reading_;
  changed_.notify_all();
  if (!opened) return finish_unread(session, opened.error().message);
  for (std::size_t i = 0; i < (*opened)->lines.size(); ++i) tasks_.push_back({*opened, i});
  if ((*opened)->lines.empty()) finish_session(**opened);
}

/// A row all the same: it says what is missing.
void BatchRun::finish_unread(const BatchSession& session, const std::string& why) {
  OpenSession unread;
  unread.place = session;
  Shot none;
  none.rejected = "session not read: " + why;
  unread.lines = {fmt::format("{},{},,{},,{}", results_line(none), data::csv_cell(session.name),
                              name(RowSource::none), id_)};
  ++progress_.unread_sessions;
  listener_({session.name, nullptr, unread.lines.front(), true, false}, progress_);
  finish_session(unread);
}

/// Sets the key; it stays empty where the photograph cannot even be read: that is tried again in the next
/// run.
BatchRow BatchRun::row_of(const BatchShot& job, std::string& key, bool& earlier) {
  std::optional<PhotographStamp> stamp;
  if (job.source == RowSource::photograph) {
    auto stamped = journal_.stamp(*job.shot->photograph);
    if (!stamped) return failed_row(*job.shot, "photograph not read: " + stamped.error().message);
    stamp = std::move(*stamped);
  }
  key = row_key(job, settings_, stamp ? stamp->hash : std::string());
  if (auto known = journal_.find(key)) {
    earlier = true;
    return *known;
  }
  BatchRow row = host::measure(job, settings_);
  if (auto added = journal_.add(key, row, stamp); !added) give_up(added.error().message);
  return row;
}

void BatchRun::measure(const Task& task) {
  const Shot& shot = task.session->stored.shots[task.shot];
  std::string key;
  bool earlier = false;
  const auto job = batch_shot(shot, settings_);
  const BatchRow row = job ? row_of(*job, key, earlier) : failed_row(shot, job.error().message);
  std::string photograph;
  if (shot.photograph) photograph = shot.photograph->lexically_relative(task.session->stored.folder).string();
  task.session->lines[task.shot] =
      fmt::format("{},{},{},{},{},{}", row.results, data::csv_cell(task.session->place.name),
                  data::csv_cell(photograph), job ? name(job->source) : name(RowSource::none), key, id_);
  finish(task, row, key, earlier);
}

void BatchRun::finish(const Task& task, const BatchRow& row, const std::string& key, bool earlier) {
  const std::lock_guard lock(mutex_);
  if (!problem_.empty()) return;
  ++progress_.rows;
  if (!earlier && !key.empty()) ++progress_.measured;
  if (row.failed) ++progress_.failed;
  listener_({task.session->place.name, &task.session->stored.shots[task.shot], task.session->lines[task.shot],
             row.failed, earlier},
            progress_);
  if (--task.session->left == 0) finish_session(*task.session);
}

/// With the mutex held, as finish_unread().
void BatchRun::finish_session(const OpenSession& session) {
  ++progress_.sessions;
  std::string lines;
  for (const std::string& line : session.lines) lines += line + "\n";
  if (!session.stored.remarks.empty()) ++progress_.sessions_with_remarks;
  const auto written = write_session_remarks(out_, session.place.name, session.stored.remarks).and_then([&] {
    return write_session_table(out_, session.place.name, lines);
  });
  if (!written && problem_.empty()) {
    problem_ = written.error().message;
    stopped_ = true;
  }
}

}  // namespace strobe::host
