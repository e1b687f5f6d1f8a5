#include "tests/benchmarks/timing/freeze_detector.hpp"

#include <linux/perf_event.h>
#include <pthread.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
#include <algorithm>
#include <exception>
#include <stdexcept>
#include <utility>

namespace strobe::benchmarks::timing {
namespace {

constexpr Duration kCollected = milliseconds(500);

void sleep_until(MonoTime deadline) {
  const timespec t{to_ns(deadline) / 1'000'000'000, to_ns(deadline) % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
  }
}

void stay_on(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(cpu), &set);
  pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

MonoTime next_whole(Duration period) { return MonoTime{(now().time_since_epoch() / period + 1) * period}; }

// 16 bytes a record: 32 s of them.
constexpr std::size_t kPage = 4096;
constexpr std::size_t kRing = 128 * kPage;
constexpr Duration kPlace = microseconds(30);
constexpr int kTrials = 50;

/// The calling thread on a core of its choice until this ends.
class Visit {
 public:
  explicit Visit(int cpu) {
    pthread_getaffinity_np(pthread_self(), sizeof cpus_, &cpus_);
    pthread_getschedparam(pthread_self(), &policy_, &param_);
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<unsigned>(cpu), &set);
    pthread_setaffinity_np(pthread_self(), sizeof set, &set);
    const sched_param first{.sched_priority = 1};
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &first);
  }
  Visit(const Visit&) = delete;
  Visit& operator=(const Visit&) = delete;
  ~Visit() {
    pthread_setschedparam(pthread_self(), policy_, &param_);
    pthread_setaffinity_np(pthread_self(), sizeof cpus_, &cpus_);
  }

 private:
  cpu_set_t cpus_{};
  int policy_ = SCHED_OTHER;
  sched_param param_{};
};

int open_event(int cpu) {
  perf_event_attr event{};
  event.size = sizeof event;
  event.type = PERF_TYPE_SOFTWARE;
  event.config = PERF_COUNT_SW_CPU_CLOCK;
  event.sample_period = static_cast<std::uint64_t>(CoreInterrupts::kPeriod.count());
  event.sample_type = PERF_SAMPLE_TIME;
  event.use_clockid = 1;
  event.clockid = CLOCK_MONOTONIC;
  event.disabled = 1;
  event.watermark = 1;
  event.wakeup_watermark = kRing;  // nobody waits
  return static_cast<int>(syscall(SYS_perf_event_open, &event, -1, cpu, -1, PERF_FLAG_FD_CLOEXEC));
}

void copy_from_ring(const char* ring, std::uint64_t at, void* to, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; ++i) static_cast<char*>(to)[i] = ring[(at + i) % kRing];
}

}  // namespace

static_assert(FreezeDetector::kPeriod == CoreInterrupts::kPeriod);

std::vector<Freeze> stops_of(std::span<const CoreInterrupt> interrupts, int cpu) {
  std::vector<Freeze> stops;
  for (std::size_t i = 1; i < interrupts.size(); ++i) {
    const MonoTime before = interrupts[i - 1].at;
    if (interrupts[i].at - before > FreezeDetector::kPeriod + FreezeDetector::kLateInterrupt)
      stops.push_back({before, interrupts[i].at, cpu});
  }
  return stops;
}

FreezeDetector::FreezeDetector(int priority, Method wanted)
    : seen_(std::max(1U, std::thread::hardware_concurrency())) {
  if (wanted == Method::interrupts && open_interrupts(seen_.size())) {
    threads_.emplace_back([this] { collect(); });
    for (std::size_t cpu = 0; cpu < seen_.size(); ++cpu)
      threads_.emplace_back([this, cpu] { keep_ticking(static_cast<int>(cpu)); });
    return;
  }
  for (std::size_t cpu = 0; cpu < seen_.size(); ++cpu)
    threads_.emplace_back([this, cpu, priority] { watch(static_cast<int>(cpu), priority, seen_[cpu]); });
}

FreezeDetector::~FreezeDetector() {
  running_ = false;
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
}

bool FreezeDetector::open_interrupts(std::size_t cores) {
  for (std::size_t cpu = 0; cpu < cores; ++cpu) {
    auto interrupts = CoreInterrupts::open(static_cast<int>(cpu));
    if (!interrupts) {
      interrupts_.clear();
      return false;
    }
    interrupts_.push_back(std::move(*interrupts));
  }
  taken_.resize(cores);
  return true;
}

void FreezeDetector::collect() {
  try {
    for (bool last = false; !last;) {
      last = !running_;
      for (std::size_t cpu = 0; cpu < interrupts_.size(); ++cpu) interrupts_[cpu].take(taken_[cpu]);
      if (!last) sleep_until(next_whole(kCollected));
    }
  } catch (const std::exception& error) {
    fault_ = error.what();
  }
}

void FreezeDetector::keep_ticking(int cpu) {
  stay_on(cpu);
  const sched_param param{};
  pthread_setschedparam(pthread_self(), SCHED_IDLE, &param);
  while (running_.load(std::memory_order_relaxed)) {
  }
}

void FreezeDetector::watch(int cpu, int priority, std::vector<Freeze>& seen) {
  stay_on(cpu);
  const sched_param param{.sched_priority = priority};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  while (running_.load(std::memory_order_relaxed)) {
    const MonoTime deadline = next_whole(kPeriod);
    sleep_until(deadline);
    const MonoTime woken = now();
    if (woken - deadline > kLateWakeUp) seen.push_back({deadline - kPeriod, woken, cpu});
  }
}

std::vector<Freeze> FreezeDetector::stop() {
  running_ = false;
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
  if (!fault_.empty()) throw std::runtime_error(fault_);
  for (std::size_t cpu = 0; cpu < taken_.size(); ++cpu)
    seen_[cpu] = stops_of(taken_[cpu], static_cast<int>(cpu));
  std::vector<Freeze> all;
  for (const auto& seen : seen_) all.insert(all.end(), seen.begin(), seen.end());
  std::sort(all.begin(), all.end(), [](const Freeze& a, const Freeze& b) { return a.begin < b.begin; });
  return all;
}

std::string freezes_in_words(const std::vector<Freeze>& freezes, FreezeDetector::Method by) {
  Duration sum{};
  Duration longest{};
  for (const Freeze& freeze : freezes) {
    sum = sum + (freeze.end - freeze.begin);
    longest = std::max(longest, freeze.end - freeze.begin);
  }
  return std::to_string(freezes.size()) +
         (by == FreezeDetector::Method::interrupts ? " stops of a core, "
                                                   : " stops of a core or late wake-ups on it, ") +
         std::to_string(sum / milliseconds(1)) + " ms in all, longest " +
         std::to_string(longest / milliseconds(1)) + " ms";
}

bool stands_still_often(const std::vector<Freeze>& freezes, Duration watched) {
  Duration sum{};
  for (const Freeze& freeze : freezes) sum = sum + (freeze.end - freeze.begin);
  return sum * 100 >= watched * static_cast<std::int64_t>(std::thread::hardware_concurrency());
}

bool within_freeze(const std::vector<Freeze>& freezes, MonoTime from, MonoTime to, int cpu) {
  return std::any_of(freezes.begin(), freezes.end(), [&](const Freeze& freeze) {
    return (cpu < 0 || cpu == freeze.cpu) && freeze.begin <= to && from <= freeze.end;
  });
}

std::optional<CoreInterrupts> CoreInterrupts::open(int cpu) {
  const int fd = open_event(cpu);
  if (fd < 0) return std::nullopt;
  void* pages = mmap(nullptr, kPage + kRing, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (pages == MAP_FAILED) {
    close(fd);
    return std::nullopt;
  }
  CoreInterrupts interrupts(fd, static_cast<char*>(pages));
  const Visit visit(cpu);
  for (int trial = 0; trial < kTrials; ++trial)
    if (interrupts.in_place()) return interrupts;
  return std::nullopt;
}

bool CoreInterrupts::in_place() {
  const MonoTime start = MonoTime{(now().time_since_epoch() / kPeriod + 2) * kPeriod};
  while (now() < start) {
  }
  ioctl(fd_, PERF_EVENT_IOC_ENABLE, 0);  // the first interrupt comes a period later
  if (now() - start < kPlace) return true;
  ioctl(fd_, PERF_EVENT_IOC_DISABLE, 0);
  return false;
}

CoreInterrupts::CoreInterrupts(CoreInterrupts&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), pages_(std::exchange(other.pages_, nullptr)), read_(other.read_) {}

CoreInterrupts::~CoreInterrupts() {
  if (pages_ != nullptr) munmap(pages_, kPage + kRing);
  if (fd_ >= 0) close(fd_);
}

void CoreInterrupts::take(std::vector<CoreInterrupt>& interrupts) {
  auto* page = reinterpret_cast<perf_event_mmap_page*>(pages_);
  const std::uint64_t written = __atomic_load_n(&page->data_head, __ATOMIC_ACQUIRE);
  bool lost = false;
  while (read_ < written) {
    perf_event_header header{};
    copy_from_ring(pages_ + kPage, read_, &header, sizeof header);
    if (header.type == PERF_RECORD_SAMPLE) {
      CoreInterrupt interrupt;
      std::int64_t at_ns = 0;
      copy_from_ring(pages_ + kPage, read_ + sizeof header, &at_ns, sizeof at_ns);
      interrupt.at = from_ns(at_ns);
      interrupt.in_kernel = (header.misc & PERF_RECORD_MISC_CPUMODE_MASK) == PERF_RECORD_MISC_KERNEL;
      interrupts.push_back(interrupt);
    }
    lost |= header.type == PERF_RECORD_LOST || header.type == PERF_RECORD_THROTTLE;
    read_ += header.size;
  }
  __atomic_store_n(&page->data_tail, read_, __ATOMIC_RELEASE);
  if (lost) throw std::runtime_error("the kernel dropped interrupts of a watched core");
}

}  // namespace strobe::benchmarks::timing
