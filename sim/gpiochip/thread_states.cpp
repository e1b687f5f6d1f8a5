#include "sim/gpiochip/thread_states.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr std::size_t kRoom = 16384;
constexpr std::int64_t kLongestPreemption = 1'000'000'000;  // then the kernel tells less than is thought
thread_local std::array<char, kRoom> stat_text;

/// As in proc(5).
char state_of(const char* stat) {
  const char* const end_of_name = strrchr(stat, ')');
  return end_of_name != nullptr && end_of_name[1] == ' ' ? end_of_name[2] : '?';
}

bool is_asleep(char state) { return strchr("STtZX", state) != nullptr; }

struct Schedule {
  std::uint64_t ran_ns = 0;
  std::uint64_t runs = 0;
};

/// Time on a processor, time of waiting for one, and how often it got one.
Schedule schedule_of(const char* schedstat) {
  Schedule schedule;
  if (schedstat == nullptr) return schedule;
  char* at = nullptr;
  schedule.ran_ns = strtoull(schedstat, &at, 10);
  strtoull(at, &at, 10);
  schedule.runs = strtoull(at, &at, 10);
  return schedule;
}

}  // namespace

ThreadStates::File::File(const char* path) : fd_(::open(path, O_RDONLY | O_CLOEXEC)) {}
ThreadStates::File::File(File&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
ThreadStates::File::~File() {
  if (fd_ >= 0) ::close(fd_);
}

const char* ThreadStates::File::read() {
  const ssize_t size = fd_ < 0 ? -1 : ::pread(fd_, stat_text.data(), stat_text.size() - 1, 0);
  if (size <= 0) return nullptr;
  stat_text[static_cast<std::size_t>(size)] = '\0';
  return stat_text.data();
}

ThreadStates::ThreadStates(pid_t excepted) : excepted_(excepted), softnet_("/proc/net/softnet_stat") {}

void ThreadStates::watch(const std::vector<pid_t>& programs) {
  std::erase_if(programs_, [&](const auto& known) {
    return std::find(programs.begin(), programs.end(), known.first) == programs.end();
  });
  for (const pid_t pid : programs) programs_.try_emplace(pid);
}

void ThreadStates::list_new_threads(pid_t pid, Program& program) const {
  char path[64];
  snprintf(path, sizeof path, "/proc/%d/task", pid);
  struct stat status {};
  const std::uint64_t links = ::stat(path, &status) == 0 ? status.st_nlink : 0;
  if (links == program.links && links != 0) return;
  program.links = links;
  program.threads.clear();
  DIR* const folder = ::opendir(path);
  if (folder == nullptr) return;
  while (const dirent* entry = ::readdir(folder)) {
    const pid_t tid = atoi(entry->d_name);
    if (tid == 0 || tid == excepted_) continue;
    const auto open = [&path, tid](const char* name) {
      char file[96];
      snprintf(file, sizeof file, "%s/%d/%s", path, tid, name);
      return File(file);
    };
    program.threads.push_back({tid, open("stat"), open("schedstat"), open("wchan")});
  }
  ::closedir(folder);
}

std::uint64_t ThreadStates::activity() {
  std::uint64_t sum = 0;
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads) {
      const Schedule schedule = schedule_of(thread.schedstat.read());
      thread.activity = schedule.ran_ns + schedule.runs;
      sum += thread.activity;
    }
  return sum;
}

bool ThreadStates::sleeps(Program& program, Thread& thread) {
  const char* const stat = thread.stat.read();
  if (stat == nullptr) {
    program.links = 0;  // that one has ended, another may have begun
    return true;
  }
  if (is_asleep(state_of(stat))) return true;
  running_ = thread.tid;
  return false;
}

bool ThreadStates::all_sleep() {
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads)
      if (!sleeps(program, thread)) return false;
  return true;
}

/// A line a core; the 12th number, where there is one, is how many packets wait in it.
bool ThreadStates::network_is_quiet() {
  const char* at = softnet_.read();
  for (int column = 1; at != nullptr && *at != '\0'; ++column) {
    char* end = nullptr;
    const unsigned long value = strtoul(at, &end, 16);
    if (column == 12 && value != 0) return false;
    if (*end == '\n') column = 0;
    at = end == at ? nullptr : end + 1;
  }
  return true;
}

/// The kernel says where a thread sleeps only if it waits for no core. One that is preempted as it lies
/// down, or while wait(2) clears up after a child, is in the state of a sleeper, too, and goes on by
/// itself.
bool ThreadStates::has_settled(Program& program, Thread& thread) const {
  if (thread.activity == thread.settled) return true;
  const char* const stat = thread.stat.read();
  if (stat == nullptr || state_of(stat) != 'S') return true;
  const char* const wchan = thread.wchan.read();
  const bool told = wchan != nullptr && strcmp(wchan, "0") != 0;
  program.tells_wchan = program.tells_wchan || told;
  return told || !program.tells_wchan;
}

bool ThreadStates::all_have_settled() {
  std::uint64_t activity = 0;
  bool settled = true;
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads) {
      settled = settled && has_settled(program, thread);
      activity += thread.activity;
    }
  if (settled || activity != unsettled_) unsettled_since_ns_ = sys::now_ns();
  unsettled_ = activity;
  return settled || sys::now_ns() - unsettled_since_ns_ > kLongestPreemption;
}

bool ThreadStates::all_asleep() {
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads)
      if (thread.tid == running_ && !sleeps(program, thread)) return false;
  running_ = 0;
  // If nobody has run between the two sums, nobody was woken but by a datagram: who slept within, slept
  // throughout. New threads make the second one larger.
  const std::uint64_t before = activity();
  for (auto& [pid, program] : programs_) list_new_threads(pid, program);
  if (!network_is_quiet() || !all_sleep() || !all_have_settled() || activity() != before) return false;
  for (auto& [pid, program] : programs_)
    for (Thread& thread : program.threads) thread.settled = thread.activity;
  return true;
}

std::uint64_t ThreadStates::consumed_ns(pid_t pid, pid_t tid) {
  const auto program = programs_.find(pid);
  if (program == programs_.end()) return 0;
  for (Thread& thread : program->second.threads)
    if (thread.tid == tid) return schedule_of(thread.schedstat.read()).ran_ns;
  return 0;
}

}  // namespace strobe::sim::gpio
