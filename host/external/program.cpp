#include "host/external/program.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <string_view>
#include <utility>

#include "common/config/files.hpp"

namespace strobe::external {

namespace fs = std::filesystem;

namespace {

constexpr const char* kLog = "messages";

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

/// What is given, then what of this process's it does not name.
std::vector<std::string> with_own_environment(std::vector<std::string> environment) {
  const auto given = static_cast<std::ptrdiff_t>(environment.size());
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view own(*entry);
    const std::string_view name = own.substr(0, own.find('=') + 1);
    if (std::none_of(environment.begin(), environment.begin() + given,
                     [name](const std::string& other) { return other.starts_with(name); }))
      environment.emplace_back(own);
  }
  return environment;
}

/// Waits for a child that nobody has waited for.
bool ends_within(pid_t child, Duration longest) {
  const auto end = std::chrono::steady_clock::now() + longest;
  const int descriptor = static_cast<int>(syscall(SYS_pidfd_open, child, 0));
  pollfd ended{descriptor, POLLIN, 0};
  int found = descriptor < 0 ? 1 : 0;  // without one it is waited for, however long
  for (auto left = longest; found == 0 && left > Duration::zero();
       left = end - std::chrono::steady_clock::now())
    found = std::max(
        0, poll(&ended, 1, static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(left).count())));
  if (descriptor >= 0) close(descriptor);
  return found > 0;
}

}  // namespace

std::optional<fs::path> find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path candidate = fs::path(folder.empty() ? "." : folder) / name;
    if (access(candidate.c_str(), X_OK) == 0) return fs::absolute(candidate);
  }
  return std::nullopt;
}

std::optional<fs::path> find_own_program(const std::string& name) {
  std::error_code error;
  const fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& folder : {here, here.parent_path() / "libexec/strobe"}) {
    if (access((folder / name).c_str(), X_OK) == 0) return folder / name;
  }
  return std::nullopt;
}

Result<WorkFolder> WorkFolder::make(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": cannot be made: " + error.message());
  std::string name = (fs::absolute(folder) / ".work-XXXXXX").string();
  if (!mkdtemp(name.data())) return fail(folder.string() + ": cannot be written: " + std::strerror(errno));
  return WorkFolder(name);
}

WorkFolder::WorkFolder(WorkFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}

WorkFolder::~WorkFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

std::string WorkFolder::last_message() const {
  std::istringstream lines(config::read_file((path_ / kLog).string()).value_or(""));
  std::string last = "no message";
  for (std::string line; std::getline(lines, line);)
    if (line.find_first_not_of(" \t\r^") != std::string::npos) last = line;
  return last;
}

Result<void> run_program(std::vector<std::string> words, const WorkFolder& folder,
                         std::vector<std::string> environment, std::optional<Duration> longest) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.path().c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, kLog, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  environment = with_own_environment(std::move(environment));
  pid_t pid = 0;
  const int error = posix_spawn(&pid, words[0].c_str(), &actions, nullptr, pointers(words).data(),
                                pointers(environment).data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return fail(words[0] + ": cannot be started: " + std::strerror(error));
  const bool late = longest && !ends_within(pid, *longest);
  if (late) kill(pid, SIGKILL);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0)
    if (errno != EINTR) return fail(words[0] + ": lost: " + std::strerror(errno));
  if (late) return fail(words[0] + ": takes too long");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return fail(words[0] + ": " + folder.last_message());
  return {};
}

}  // namespace strobe::external
