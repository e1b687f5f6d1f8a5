#include "host/web/http/worker.hpp"

#include <atomic>
#include <chrono>
#include <utility>

#include "host/web/http/background.hpp"

namespace strobe::web {
namespace {

constexpr std::chrono::milliseconds kMaxWaitAtEnd{200};
std::atomic<bool> left_behind{false};

}  // namespace

Worker::Worker(std::size_t max_waiting) : max_waiting_(max_waiting) {
  background_thread("strobe-web-work", [state = state_] {
    run(*state);
    const std::lock_guard lock(state->mutex);
    state->ended = true;
    state->changed.notify_all();
  }).detach();
}

void Worker::run(State& state) {
  std::unique_lock lock(state.mutex);
  while (true) {
    state.changed.wait(lock, [&state] { return state.ending || !state.jobs.empty(); });
    if (state.ending) return;
    auto job = std::move(state.jobs.front());
    state.jobs.pop_front();
    state.busy = true;
    lock.unlock();
    job();
    job = nullptr;
    lock.lock();
    state.busy = false;
  }
}

bool Worker::add(std::function<void()> job) {
  const std::lock_guard lock(state_->mutex);
  if (state_->ending || state_->jobs.size() >= max_waiting_) return false;
  state_->jobs.push_back(std::move(job));
  state_->changed.notify_all();
  return true;
}

bool Worker::end() {
  std::unique_lock lock(state_->mutex);
  state_->ending = true;
  state_->jobs.clear();
  state_->changed.notify_all();
  state_->changed.wait_for(lock, kMaxWaitAtEnd, [this] { return state_->ended; });
  if (state_->busy) {
    left_behind = true;
    return false;
  }
  state_->changed.wait(lock, [this] { return state_->ended; });  // as soon as it gets the processor
  return true;
}

bool work_left_behind() { return left_behind; }

}  // namespace strobe::web
