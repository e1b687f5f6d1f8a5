#include "host/web/http/worker.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <exception>
#include <utility>

namespace strobe::web {
namespace {

constexpr int kNiceness = 10;

/// While it lives, this thread and those that it starts get no signals.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_{};
};

/// Where the system does not allow it the thread runs like others.
void become_background(const char* name) {
  const sched_param none{};
  sched_setscheduler(0, SCHED_BATCH, &none);
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNiceness);
  prctl(PR_SET_NAME, name);
}

constexpr std::chrono::milliseconds kMaxWaitAtEnd{200};
std::atomic<bool> left_behind{false};

}  // namespace

std::thread background_thread(const char* name, std::function<void()> work) {
  const SignalsBlocked blocked;
  return std::thread([name, work = std::move(work)] {
    become_background(name);
    try {
      work();
    } catch (const std::exception&) {  // such as memory that was not to be had
    }
  });
}

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
