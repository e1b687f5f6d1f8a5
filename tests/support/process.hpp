// Child processes of tests: started with files for their output, waited for with a time limit, and never left
// behind. One thread per Process. Failures to start are reported by std::runtime_error: a test cannot go on
// without its process.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace strobe::testing {

/// How a process ended.
struct ExitStatus {
  int code = -1;   ///< exit status; -1 if a signal ended it
  int signal = 0;  ///< 0 if it exited
  bool operator==(const ExitStatus&) const = default;
  friend std::ostream& operator<<(std::ostream& stream, const ExitStatus& status) {
    return status.signal == 0 ? stream << "exit " << status.code : stream << "signal " << status.signal;
  }
};

/// What a process may do.
enum class Privileges {
  inherited,  ///< the same as the test program
  ordinary,   ///< an ordinary user's: without capabilities, real-time priority and more than 64 KiB of locked
              ///< memory
};

struct Command {
  /// The program, then its arguments; not searched in PATH if it has a slash.
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment{};  ///< added to, or replacing, the test's own
  std::filesystem::path folder{};                    ///< working folder; empty: the test's
  Privileges rights = Privileges::inherited;
};

class Process {
 public:
  /// Starts the command in a process group of its own, without standard input. Its outputs go to files in
  /// `log_folder`.
  Process(const Command& command, const std::filesystem::path& log_folder);
  Process(Process&&) noexcept;
  Process& operator=(Process&&) = delete;
  /// Asks the process to end, gives it a second for that, then kills the group.
  ~Process();

  pid_t pid() const;
  bool running();

  /// How it ended; nothing if it still runs after `limit`.
  std::optional<ExitStatus> wait(std::chrono::milliseconds limit);

  void signal(int number);        ///< to the process alone
  void signal_group(int number);  ///< to its whole group

  std::string out() const;  ///< standard output so far
  std::string err() const;  ///< standard error so far

  /// Waits until standard output or standard error holds the text; false once the process ended or the limit
  /// passed without it.
  bool wait_for_out(const std::string& text, std::chrono::milliseconds limit);
  bool wait_for_err(const std::string& text, std::chrono::milliseconds limit);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct CompletedProcess {
  std::optional<ExitStatus> status;  ///< nothing: it did not end in time and was killed
  std::string out, err;
};

/// Runs a command to its end.
CompletedProcess run_process(const Command& command, std::chrono::milliseconds limit);

/// Processes whose parent is `pid`, oldest first.
std::vector<pid_t> children_of(pid_t pid);

/// The process itself and all that descend from it, parents before children.
std::vector<pid_t> descendants_of(pid_t pid);

/// Name of the program that a process runs (at most 15 characters); empty once it is gone.
std::string program_of(pid_t pid);

/// Instant of CLOCK_MONOTONIC. [ns]
std::int64_t monotonic_now_ns();

/// Waits until `done` is true or the limit passed; returns its last answer. Asks every millisecond.
template <typename Condition>
bool wait_until(Condition done, std::chrono::milliseconds limit);

void sleep_for(std::chrono::milliseconds time);

template <typename Condition>
bool wait_until(Condition done, std::chrono::milliseconds limit) {
  const std::int64_t end = monotonic_now_ns() + std::chrono::nanoseconds(limit).count();
  while (!done()) {
    if (monotonic_now_ns() >= end) return done();
    sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace strobe::testing
