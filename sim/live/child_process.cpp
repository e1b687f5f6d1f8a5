#include "sim/live/child_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <thread>

namespace strobe::sim {

namespace {

sigset_t child_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGCHLD}) sigaddset(&set, signal);
  return set;
}

[[noreturn]] void become(const std::vector<std::string>& command,
                         const std::vector<std::pair<std::string, std::string>>& environment, int report) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  signal(SIGXFSZ, SIG_DFL);  // which strobe-sim ignores
  const sigset_t set = child_signals();
  sigprocmask(SIG_UNBLOCK, &set, nullptr);
  for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  const int error = errno;
  static_cast<void>(!write(report, &error, sizeof error));
  _exit(127);
}

namespace fs = std::filesystem;

constexpr int kTries = 100;
constexpr std::chrono::milliseconds kTryEvery{100};

/// LD_PRELOAD is split at blanks and colons: a library whose path has some is reached by a link, as long as
/// this program lives.
fs::path preloadable(const fs::path& library) {
  if (library.string().find_first_of(" :") == std::string::npos) return library;
  static const TemporaryFolder folder;
  const fs::path link = folder.path() / library.filename();
  std::error_code error;
  fs::create_symlink(library, link, error);
  return fs::exists(link, error) ? link : library;
}

std::string preload_with(const fs::path& library) {
  const char* before = std::getenv("LD_PRELOAD");
  return before && *before ? library.string() + ":" + before : library.string();
}

}  // namespace

void block_child_signals() {
  const sigset_t set = child_signals();
  sigprocmask(SIG_BLOCK, &set, nullptr);
}

Result<int> start_child(const std::vector<std::string>& command,
                        const std::vector<std::pair<std::string, std::string>>& environment,
                        const std::function<void()>& first) {
  int report[2];  // closed by a successful exec, else it carries errno
  if (pipe2(report, O_CLOEXEC) != 0) return fail(std::string("pipe: ") + std::strerror(errno));
  const pid_t pid = fork();
  if (pid < 0) {
    const int error = errno;
    close(report[0]);
    close(report[1]);
    return fail(std::string("fork: ") + std::strerror(error));
  }
  if (pid == 0) {
    if (first) first();
    become(command, environment, report[1]);
  }
  close(report[1]);
  int error = 0;
  const ssize_t got = read(report[0], &error, sizeof error);
  close(report[0]);
  if (got == static_cast<ssize_t>(sizeof error)) {
    waitpid(pid, nullptr, 0);
    return fail(command[0] + ": " + std::strerror(error));
  }
  return pid;
}

int wait_for_child(int pid) {
  const sigset_t set = child_signals();
  while (true) {
    int status = 0;
    if (waitpid(pid, &status, WNOHANG) == pid) {
      if (WIFEXITED(status)) return WEXITSTATUS(status);
      if (WIFSIGNALED(status)) return 128 + WTERMSIG(status);
    }
    siginfo_t info{};
    const int signal = sigwaitinfo(&set, &info);
    const bool from_terminal = info.si_code == SI_KERNEL;
    if (signal > 0 && signal != SIGCHLD && !from_terminal) kill(pid, signal);
  }
}

Result<int> start_joined(const std::vector<std::string>& command, const fs::path& chip_folder,
                         const std::function<void()>& join) {
  const auto library = preload_path();
  if (!library) return tl::unexpected(library.error());
  return start_child(
      command,
      {{"LD_PRELOAD", preload_with(preloadable(*library))}, {kChipDirVariable, chip_folder.string()}}, join);
}

Result<Chip> attach_to_rig(const fs::path& chip_folder) {
  auto chip = Chip::attach(chip_folder);
  for (int tries = 0; !chip && tries < kTries; ++tries) {
    std::this_thread::sleep_for(kTryEvery);
    chip = Chip::attach(chip_folder);
  }
  return chip;
}

}  // namespace strobe::sim
