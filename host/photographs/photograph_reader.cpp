#include "host/photographs/photograph_reader.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>
#include <exception>
#include <system_error>
#include <utility>

#include "common/config/files.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTryEvery{50};

struct FileState {
  std::uintmax_t size = 0;
  fs::file_time_type changed;
  bool operator==(const FileState&) const = default;
};

FileState state_of(const fs::path& file) {
  std::error_code error;
  FileState state;
  state.size = fs::file_size(file, error);
  state.changed = fs::last_write_time(file, error);
  return state;
}

/// A link lasts once its folder is synced, which takes its time: before the next shot (SessionFolder::sync).
std::string keep(const PhotographJob& job) try {
  std::error_code error;
  const fs::path folder = job.keep_as.parent_path();
  fs::create_directories(folder, error);
  if (job.may_link) {
    fs::create_hard_link(job.file, job.keep_as, error);
    if (!error) return {};
  }
  const auto copied = config::copy_file(job.file, job.keep_as);
  return copied ? std::string() : copied.error().message;
} catch (const std::exception& error) {
  return job.keep_as.string() + ": " + error.what();
}

}  // namespace

PhotographReader::PhotographReader(MeasurePhotograph measure, double retry_timeout_s)
    : measure_(std::move(measure)),
      retry_timeout_s_(retry_timeout_s),
      event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      thread_([this] { run(); }) {}

PhotographReader::~PhotographReader() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
  if (event_ >= 0) close(event_);
}

void PhotographReader::add(PhotographJob job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
    ++pending_;
  }
  changed_.notify_all();
}

std::vector<PhotographResult> PhotographReader::take_results() {
  std::uint64_t count = 0;
  if (event_ >= 0) static_cast<void>(!read(event_, &count, sizeof count));
  const std::lock_guard lock(mutex_);
  pending_ -= results_.size();
  return std::exchange(results_, {});
}

std::vector<PhotographLight> PhotographReader::take_light() {
  const std::lock_guard lock(mutex_);
  return std::exchange(light_, {});
}

std::size_t PhotographReader::pending() const {
  const std::lock_guard lock(mutex_);
  return pending_;
}

tl::expected<PhotographReading, UnreadPhotograph> PhotographReader::read_once(
    const PhotographJob& job) const {
  try {
    return measure_(job.file, job.flash_times_s);
  } catch (const std::exception& error) {
    return tl::unexpected(UnreadPhotograph{job.file.filename().string() + ": " + error.what(), false});
  }
}

tl::expected<PhotographReading, UnreadPhotograph> PhotographReader::read_when_whole(
    const PhotographJob& job) {
  FileState state = state_of(job.file);
  SteadyClock::time_point changed = SteadyClock::now();
  while (true) {
    auto reading = read_once(job);
    if (reading || !reading.error().unfinished) return reading;
    // Tried again once it has changed and then stayed the same for a moment.
    bool fresh = false;
    while (true) {
      std::unique_lock lock(mutex_);
      if (changed_.wait_for(lock, kTryEvery, [this] { return stopping_; })) return reading;
      lock.unlock();
      const FileState now = state_of(job.file);
      if (fresh && now == state) break;
      if (now != state) fresh = true, changed = SteadyClock::now();
      state = now;
      if (std::chrono::duration<double>(SteadyClock::now() - changed).count() > retry_timeout_s_)
        return reading;
    }
  }
}

/// One that nobody changes any more is kept first: a host that is killed meanwhile leaves it in the session.
PhotographResult PhotographReader::work(PhotographJob job) {
  PhotographResult result;
  const bool to_keep = !job.keep_as.empty();
  const bool kept_first = to_keep && job.may_link && keep(job).empty();
  result.reading = job.measure ? read_when_whole(job) : PhotographReading{};
  std::error_code error;
  if (kept_first && !result.reading) fs::remove(job.keep_as, error);
  if (to_keep && !kept_first && result.reading) result.not_kept = keep(job);
  result.job = std::move(job);
  return result;
}

void PhotographReader::wake() const {
  const std::uint64_t one = 1;
  if (event_ >= 0) static_cast<void>(!write(event_, &one, sizeof one));
}

void PhotographReader::judge_light(const ShotKey& shot, const AdviseOnLight& advise) {
  if (!advise) return;
  std::vector<light::Advice> advice;
  try {
    advice = advise();
  } catch (const std::exception&) {  // what is not known of the light is not said
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    light_.push_back({shot, std::move(advice)});
  }
  wake();
}

void PhotographReader::run() {
  while (true) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
    if (stopping_) return;
    PhotographJob job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    PhotographResult result = work(std::move(job));
    const ShotKey shot = result.job.shot;
    const auto advise = result.reading ? std::exchange(result.reading->advise, nullptr) : nullptr;
    lock.lock();
    results_.push_back(std::move(result));
    lock.unlock();
    wake();
    judge_light(shot, advise);
  }
}

}  // namespace strobe::host
