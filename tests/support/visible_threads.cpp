// Under the thread sanitizer OpenCV's parallel loops run on threads that the sanitizer sees: those of the
// library that it comes with (oneTBB) are not built for it, so that every loop would look like a race. Linked
// into the tests of whatever uses such loops.
#include <algorithm>
#include <atomic>
#include <memory>
#include <opencv2/core/parallel/parallel_backend.hpp>
#include <thread>
#include <vector>

namespace {

thread_local int thread_number = 0;

class VisibleThreads : public cv::parallel::ParallelForAPI {
 public:
  void parallel_for(int tasks, FN_parallel_for_body_cb_t body, void* data) override {
    std::atomic<int> next{0};
    const auto work = [&](int number) {
      thread_number = number;
      for (int task = next++; task < tasks; task = next++) body(task, task + 1, data);
      thread_number = 0;
    };
    std::vector<std::thread> others;
    for (int number = 1; number < std::min(kThreads, tasks); ++number) others.emplace_back(work, number);
    work(0);
    for (std::thread& thread : others) thread.join();
  }
  int getThreadNum() const override { return thread_number; }
  int getNumThreads() const override { return kThreads; }
  int setNumThreads(int) override { return kThreads; }
  const char* getName() const override { return "visible"; }

 private:
  static constexpr int kThreads = 3;
};

const bool installed = [] {
  cv::parallel::setParallelForBackend(std::make_shared<VisibleThreads>());
  return true;
}();

}  // namespace
