#include "tests/support/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "tests/support/temporary_folder.hpp"

extern char** environ;

namespace strobe::testing {
namespace {

[[noreturn]] void give_up(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

std::string contents(const std::filesystem::path& path) {
  const std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();  // does not throw if a process ends while its file in /proc is read
  return text.str();
}

std::vector<std::string> merged_environment(const std::map<std::string, std::string>& added) {
  std::vector<std::string> merged;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (added.count(text.substr(0, text.find('='))) == 0) merged.push_back(text);
  }
  for (const auto& [name, value] : added) merged.push_back(name + "=" + value);
  return merged;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

/// After fork, before exec: without these a program cannot take a real-time priority nor lock its memory,
/// whoever runs it. Dropping the bounding set empties what root's exec would otherwise grant.
bool drop_rights() {
  constexpr rlim_t kLockedBytes = 64 * 1024;
  const rlimit none{0, 0};
  const rlimit locked{kLockedBytes, kLockedBytes};
  if (setrlimit(RLIMIT_RTPRIO, &none) != 0 || setrlimit(RLIMIT_MEMLOCK, &locked) != 0) return false;
  if (geteuid() != 0) return true;
  for (unsigned long capability = 0; prctl(PR_CAPBSET_READ, capability, 0, 0, 0) >= 0; ++capability)
    if (prctl(PR_CAPBSET_DROP, capability, 0, 0, 0) != 0) return false;
  return true;
}

struct Prepared {
  std::vector<std::string> arguments;
  std::vector<std::string> environment;
  std::string folder;
  int out = -1, err = -1, null = -1;
};

[[noreturn]] void become(Prepared& prepared, Privileges rights) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test killed by its time limit leaves nothing running
  dup2(prepared.null, STDIN_FILENO);
  dup2(prepared.out, STDOUT_FILENO);
  dup2(prepared.err, STDERR_FILENO);
  // Signals as a shell would give them: what starts the tests may ignore some (nohup, a background job).
  for (int number = 1; number < NSIG; ++number) signal(number, SIG_DFL);
  sigset_t nothing;
  sigemptyset(&nothing);
  sigprocmask(SIG_SETMASK, &nothing, nullptr);
  if (!prepared.folder.empty() && chdir(prepared.folder.c_str()) != 0) _exit(126);
  if (rights == Privileges::ordinary && !drop_rights()) _exit(126);
  std::vector<char*> arguments = pointers(prepared.arguments);
  std::vector<char*> environment = pointers(prepared.environment);
  execvpe(arguments[0], arguments.data(), environment.data());
  _exit(127);
}

int open_output(const std::filesystem::path& path) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) give_up("cannot write " + path.string());
  return file;
}

/// Name and parent from /proc/PID/stat; the name is in brackets and may hold any character.
struct Stat {
  std::string program;
  char state = '?';
  pid_t parent = -1;
};

std::optional<Stat> stat_of(pid_t pid) {
  const std::string text = contents("/proc/" + std::to_string(pid) + "/stat");
  const std::size_t open = text.find('('), close = text.rfind(')');
  if (open == std::string::npos || close == std::string::npos) return std::nullopt;
  Stat stat;
  stat.program = text.substr(open + 1, close - open - 1);
  std::istringstream rest(text.substr(close + 1));
  rest >> stat.state >> stat.parent;
  return stat;
}

int next_log_number() {
  static std::atomic<int> number = 0;
  return ++number;
}

}  // namespace

struct Process::State {
  pid_t pid = -1;
  int descriptor = -1;
  std::filesystem::path out_file;
  std::filesystem::path err_file;
  std::optional<ExitStatus> ended;

  ~State() {
    if (pid > 0) {
      if (!ended) let_it_clean_up();
      kill(-pid, SIGKILL);
      if (!ended) waitpid(pid, nullptr, 0);
    }
    if (descriptor >= 0) close(descriptor);
  }

  /// Asked to end, a program removes the folders that it made.
  void let_it_clean_up() const {
    constexpr int kPatienceMs = 1000;
    kill(pid, SIGTERM);
    pollfd ready{descriptor, POLLIN, 0};
    poll(&ready, 1, kPatienceMs);
  }
};

Process::Process(const Command& command, const std::filesystem::path& log_folder)
    : state_(std::make_unique<State>()) {
  Prepared prepared{command.arguments, merged_environment(command.environment), command.folder.string()};
  const std::string stem = std::filesystem::path(command.arguments.at(0)).filename().string() + "." +
                           std::to_string(next_log_number());
  state_->out_file = log_folder / (stem + ".out");
  state_->err_file = log_folder / (stem + ".err");
  prepared.out = open_output(state_->out_file);
  prepared.err = open_output(state_->err_file);
  prepared.null = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const pid_t pid = fork();
  if (pid == 0) become(prepared, command.rights);
  close(prepared.out);
  close(prepared.err);
  close(prepared.null);
  if (pid < 0) give_up("cannot fork");
  setpgid(pid, pid);  // here as well: the group exists before anybody signals it
  state_->pid = pid;
  // glibc 2.36 declares it for C only
  state_->descriptor = static_cast<int>(syscall(SYS_pidfd_open, pid, 0));
  if (state_->descriptor < 0) give_up("pidfd_open");
}

Process::Process(Process&&) noexcept = default;
Process::~Process() = default;

pid_t Process::pid() const { return state_->pid; }

bool Process::running() { return !wait(std::chrono::milliseconds(0)).has_value(); }

std::optional<ExitStatus> Process::wait(std::chrono::milliseconds limit) {
  if (state_->ended) return state_->ended;
  const std::int64_t end = monotonic_now_ns() + std::chrono::nanoseconds(limit).count();
  for (;;) {
    pollfd ready{state_->descriptor, POLLIN, 0};
    const std::int64_t left_ms = std::max<std::int64_t>(0, (end - monotonic_now_ns() + 999'999) / 1'000'000);
    const int polled = poll(&ready, 1, static_cast<int>(left_ms));
    if (polled > 0) break;
    if (polled == 0) return std::nullopt;
    if (errno != EINTR) give_up("poll");
  }
  int status = 0;
  if (waitpid(state_->pid, &status, 0) != state_->pid) give_up("waitpid");
  state_->ended = WIFEXITED(status) ? ExitStatus{WEXITSTATUS(status), 0} : ExitStatus{-1, WTERMSIG(status)};
  return state_->ended;
}

void Process::signal(int number) {
  if (!state_->ended) kill(state_->pid, number);
}

void Process::signal_group(int number) { kill(-state_->pid, number); }

std::string Process::out() const { return contents(state_->out_file); }
std::string Process::err() const { return contents(state_->err_file); }

bool Process::wait_for_out(const std::string& text, std::chrono::milliseconds limit) {
  const auto there = [&] { return out().find(text) != std::string::npos; };
  wait_until([&] { return there() || !running(); }, limit);
  return there();
}

bool Process::wait_for_err(const std::string& text, std::chrono::milliseconds limit) {
  const auto there = [&] { return err().find(text) != std::string::npos; };
  wait_until([&] { return there() || !running(); }, limit);
  return there();
}

CompletedProcess run_process(const Command& command, std::chrono::milliseconds limit) {
  const TemporaryFolder logs;
  Process process(command, logs.path());
  const std::optional<ExitStatus> status = process.wait(limit);
  if (!status) process.signal_group(SIGKILL);
  return {status, process.out(), process.err()};
}

std::vector<pid_t> children_of(pid_t pid) {
  std::vector<pid_t> children;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const pid_t candidate = static_cast<pid_t>(std::stol(name));
    const std::optional<Stat> stat = stat_of(candidate);
    if (stat && stat->parent == pid && stat->state != 'Z') children.push_back(candidate);
  }
  std::sort(children.begin(), children.end());
  return children;
}

std::vector<pid_t> descendants_of(pid_t pid) {
  std::vector<pid_t> all{pid};
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::vector<pid_t> children = children_of(all[i]);
    all.insert(all.end(), children.begin(), children.end());
  }
  return all;
}

std::string program_of(pid_t pid) {
  const std::optional<Stat> stat = stat_of(pid);
  return stat && stat->state != 'Z' ? stat->program : std::string();
}

std::int64_t monotonic_now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

void sleep_for(std::chrono::milliseconds time) {
  timespec left{static_cast<time_t>(time.count() / 1000), static_cast<long>(time.count() % 1000) * 1'000'000};
  while (nanosleep(&left, &left) != 0 && errno == EINTR) {
  }
}

}  // namespace strobe::testing
