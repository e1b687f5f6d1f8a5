// Work on several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace strobe::studies {

/// work(i) for i in [0, count); returns when all are done. `work` must not throw.
template <typename Work>
void in_parallel(std::size_t count, unsigned threads, const Work& work) {
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> workers;
  for (unsigned i = 0; i < std::max(1U, threads); ++i)
    workers.emplace_back([&] {
      for (std::size_t k = next++; k < count; k = next++) work(k);
    });
}

}  // namespace strobe::studies
