#include "host/thesis/figures/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "common/config/files.hpp"

namespace strobe::report {

namespace fs = std::filesystem;

namespace {

/// A folder that goes when the object does, with all that is in it.
class Workshop {
 public:
  static Result<Workshop> make(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return fail(folder.string() + ": cannot be made: " + error.message());
    std::string name = (folder / ".drawing-XXXXXX").string();
    if (!mkdtemp(name.data())) return fail(folder.string() + ": cannot be written: " + std::strerror(errno));
    return Workshop(name);
  }
  Workshop(Workshop&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  Workshop& operator=(Workshop&&) = delete;
  ~Workshop() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  explicit Workshop(fs::path path) : path_(std::move(path)) {}
  fs::path path_;
};

std::string read(const fs::path& path) { return config::read_file(path.string()).value_or(""); }

std::string first_complaint(const std::string& log) {
  std::istringstream lines(log);
  std::string line;
  std::string last;
  while (std::getline(lines, line))
    if (line.find_first_not_of(" \t^") != std::string::npos) last = line;
  return last.empty() ? "no message" : last;
}

Result<void> run(const fs::path& gnuplot, const std::string& script, const fs::path& folder) {
  const fs::path log = folder / "gnuplot.log";
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "gnuplot.log", O_WRONLY | O_CREAT | O_TRUNC,
                                   0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  std::string program = gnuplot.string();
  std::string file = script;
  char* arguments[] = {program.data(), file.data(), nullptr};
  pid_t pid = 0;
  const int error = posix_spawn(&pid, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return fail(program + ": cannot be started: " + std::strerror(error));
  int status = 0;
  while (waitpid(pid, &status, 0) < 0)
    if (errno != EINTR) return fail(program + ": lost: " + std::strerror(errno));
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return fail("gnuplot did not draw " + script + ": " + first_complaint(read(log)));
  return {};
}

/// Both formats say where they end.
bool whole(const fs::path& path) {
  const std::string content = read(path);
  const std::string tail = content.size() < 16 ? content : content.substr(content.size() - 16);
  return tail.find(path.extension() == ".svg" ? "</svg>" : "IEND") != std::string::npos;
}

}  // namespace

Result<fs::path> find_gnuplot() {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  std::string folder;
  while (std::getline(folders, folder, ':')) {
    const fs::path candidate = fs::path(folder.empty() ? "." : folder) / "gnuplot";
    if (access(candidate.c_str(), X_OK) == 0) return fs::absolute(candidate);
  }
  return fail("figures need gnuplot, which is not installed: apt-get install gnuplot-nox");
}

Result<void> draw(const Figure& figure, const fs::path& folder, const fs::path& gnuplot) {
  const auto workshop = Workshop::make(folder);
  if (!workshop) return tl::unexpected(workshop.error());
  const std::string stem = file_stem(figure);
  const fs::path& in = workshop->path();
  if (const auto done = config::write_file(in / (stem + ".csv"), csv_text(figure)); !done) return done;
  if (const auto done = config::write_file(in / (stem + ".gp"), script_text(figure)); !done) return done;
  if (const auto done = run(gnuplot, stem + ".gp", in); !done) return done;
  for (const char* kind : {".svg", ".png"})
    if (!whole(in / (stem + kind)))
      return fail("gnuplot did not finish " + stem + kind + ": " + first_complaint(read(in / "gnuplot.log")));
  for (const char* kind : {".csv", ".gp", ".svg", ".png"}) {
    std::error_code error;
    fs::rename(in / (stem + kind), folder / (stem + kind), error);
    if (error) return fail((folder / (stem + kind)).string() + ": cannot be written: " + error.message());
  }
  return {};
}

}  // namespace strobe::report
