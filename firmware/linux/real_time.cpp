#include "firmware/linux/real_time.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <sstream>

namespace strobe::firmware {

LatencyRequest::LatencyRequest() {
  fd_ = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  const std::int32_t microseconds_allowed = 0;
  if (fd_ < 0 ||
      write(fd_, &microseconds_allowed, sizeof microseconds_allowed) != sizeof microseconds_allowed) {
    fault_ = std::string("/dev/cpu_dma_latency: ") + std::strerror(errno) +
             "; deep sleep states of the processor stay allowed (give the user write access)";
  }
}

LatencyRequest::~LatencyRequest() {
  if (fd_ >= 0) close(fd_);
}

std::string lock_memory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) {
    // Within a finite limit a later allocation would fail in the middle of a shot; root is exempt, if it is
    // real.
    if (limit.rlim_cur == RLIM_INFINITY) return "";
    constexpr std::size_t kMoreThanLimits = std::size_t{64} << 20;
    if (limit.rlim_cur < kMoreThanLimits) {
      void* trial =
          mmap(nullptr, kMoreThanLimits, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
      if (trial != MAP_FAILED) {
        munmap(trial, kMoreThanLimits);
        return "";
      }
      munlockall();
    } else {
      return "";
    }
  }
  return "memory cannot be locked (limit " + std::to_string(limit.rlim_cur >> 10) +
         " KiB): set LimitMEMLOCK=infinity or give CAP_IPC_LOCK";
}

std::string become_real_time(int priority) {
  sched_param param{};
  param.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  if (error == 0) return "";
  return "SCHED_FIFO " + std::to_string(priority) + " was refused (" + std::strerror(error) +
         "): set LimitRTPRIO or give CAP_SYS_NICE";
}

void become_ordinary() {
  const sched_param ordinary{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
}

std::string pin_to_cpu(int cpu) {
  if (cpu < 0) return "";
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
  if (error == 0) return "";
  return "real_time.cpu: CPU " + std::to_string(cpu) + " cannot be used (" + std::strerror(error) + ")";
}

void allow_any_cpu(pid_t thread) {
  cpu_set_t all;
  CPU_ZERO(&all);
  for (std::size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) CPU_SET(cpu, &all);
  sched_setaffinity(thread, sizeof all, &all);
}

void exclude_cpu(int cpu) {
  cpu_set_t set;
  if (cpu < 0 || sched_getaffinity(0, sizeof set, &set) != 0) return;
  CPU_CLR(static_cast<std::size_t>(cpu), &set);
  if (CPU_COUNT(&set) > 0) sched_setaffinity(0, sizeof set, &set);
}

namespace {

/// Runs in the child: one line for each right, empty if it was granted.
std::string trial_lines(const Rig::RealTime& wanted) {
  std::string lines;
  const std::string lowest = become_real_time(sched_get_priority_min(SCHED_FIFO));
  const std::string priority = lowest.empty() ? become_real_time(wanted.priority) : "";
  for (const std::string& fault :
       {lowest, priority, lock_memory(), pin_to_cpu(wanted.cpu), LatencyRequest().fault()}) {
    lines += fault + "\n";
  }
  return lines;
}

}  // namespace

RealTimeRights probe_real_time(const Rig::RealTime& wanted) {
  int result[2];
  RealTimeRights trial;
  if (pipe(result) != 0) {
    trial.policy = std::string("pipe: ") + std::strerror(errno);
    return trial;
  }
  const pid_t child = fork();
  if (child == 0) {
    const std::string lines = trial_lines(wanted);
    _exit(write(result[1], lines.data(), lines.size()) == static_cast<ssize_t>(lines.size()) ? 0 : 1);
  }
  close(result[1]);
  // Where another thread never leaves the CPU, the child does not get there.
  constexpr int kStarved_ms = 1000;
  pollfd answer{result[0], POLLIN, 0};
  const bool starved = child > 0 && poll(&answer, 1, kStarved_ms) == 0;
  if (starved) allow_any_cpu(child);
  std::string all;
  char part[512];
  for (ssize_t n = 0; (n = read(result[0], part, sizeof part)) > 0;)
    all.append(part, static_cast<std::size_t>(n));
  close(result[0]);
  if (child > 0) waitpid(child, nullptr, 0);
  std::istringstream lines(all);
  for (std::string* fault : {&trial.policy, &trial.priority, &trial.memory, &trial.pinning, &trial.latency}) {
    if (!std::getline(lines, *fault)) *fault = "the trial of this right ended early";
  }
  if (starved)
    trial.pinning = "CPU " + std::to_string(wanted.cpu) +
                    " cannot be had: threads of a higher real-time priority never leave it";
  return trial;
}

void use_small_stacks() {
#ifdef __SANITIZE_THREAD__
  constexpr std::size_t kStack_bytes = std::size_t{8} << 20;  // the sanitizer keeps its own state there
#else
  constexpr std::size_t kStack_bytes = std::size_t{512} << 10;
#endif
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStack_bytes);
  pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

void prefault_stack() {
  constexpr std::size_t kBytes = std::size_t{128} << 10;
  volatile unsigned char touched[kBytes];
  for (std::size_t i = 0; i < kBytes; i += 1024) touched[i] = 1;
  (void)touched[0];
}

void keep_memory() {
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
}

}  // namespace strobe::firmware
