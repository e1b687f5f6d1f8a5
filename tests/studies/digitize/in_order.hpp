// Work on several threads whose results are taken one by one, in order, on the caller's: the same whatever
// the number of threads.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdio>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "common/result.hpp"

namespace strobe::studies::digitize {

/// make(i) for i in [0, count) on `threads` threads; take(i, result) here. take returns false: no more is
/// begun. `make` must be callable from several threads at once and not throw.
template <typename Make, typename Take>
void in_order(std::size_t count, int threads, const Make& make, const Take& take) {
  using Made = decltype(make(std::size_t{}));
  std::vector<std::optional<Made>> made(count);
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::condition_variable ready;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      Made one = make(i);
      const std::lock_guard lock(mutex);
      made[i].emplace(std::move(one));
      ready.notify_one();
    }
  };
  std::vector<std::jthread> workers;
  for (int i = 0; i < threads; ++i) workers.emplace_back(work);
  for (std::size_t i = 0; i < count; ++i) {
    std::unique_lock lock(mutex);
    ready.wait(lock, [&] { return made[i].has_value(); });
    Made one = std::move(*made[i]);
    made[i].reset();
    lock.unlock();
    if (take(i, one)) continue;
    next = count;
    return;
  }
}

/// "137 of 2100 photographs" on stderr every ten seconds.
class Progress {
 public:
  explicit Progress(std::size_t of) : of_(of) {}
  void done(std::size_t count) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::seconds(10)) return;
    last_ = now;
    std::fprintf(stderr, "strobe-bench: %zu of %zu photographs\n", count, of_);
  }

 private:
  std::size_t of_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// make(i) as above gives a Result; take(i, value) of each until one is an error, which is returned. Shows progress.
template <typename Make, typename Take>
Result<void> try_in_order(std::size_t count, int threads, const Make& make, const Take& take) {
  Progress progress(count);
  Result<void> all;
  in_order(count, threads, make, [&](std::size_t i, auto& made) {
    if (!made) {
      all = tl::unexpected(made.error());
      return false;
    }
    take(i, *made);
    progress.done(i + 1);
    return true;
  });
  return all;
}

}  // namespace strobe::studies::digitize
