// Runs one command: environment, forwarded signals, exit status.
// For the main thread of a program, before it starts others: signals are blocked in it and in all threads
// after it.
#pragma once

#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "sim/gpiochip/chip.hpp"

namespace strobe::sim {

/// Blocks the signals that wait_for_child() handles: SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGCHLD. Call it
/// before any thread is started.
void block_child_signals();

/// Starts `command` (looked up in PATH) with these environment variables set and all others kept. The child
/// is sent SIGTERM if this process dies. Fails if the command cannot be executed. `first`: what the child
/// does before.
Result<int> start_child(const std::vector<std::string>& command,
                        const std::vector<std::pair<std::string, std::string>>& environment,
                        const std::function<void()>& first = {});

/// Waits for the child's end, forwarding SIGINT, SIGTERM, SIGHUP and SIGQUIT (but not those that a terminal
/// sends to the whole foreground, which the child gets anyway). Gives its exit status, or 128 plus the signal
/// that ended it.
int wait_for_child(int pid);

// Starts programs that see a chip's folder as a GPIO chip of the machine and live in its rig's time.

/// start_child() with the library beside this program preloaded. `join`: makes the child take part in rig
/// time.
Result<int> start_joined(const std::vector<std::string>& command, const std::filesystem::path& chip_folder,
                         const std::function<void()>& join);

/// The chip of a rig that may have been started just before: waits for it, ten seconds at most.
Result<Chip> attach_to_rig(const std::filesystem::path& chip_folder);

// A folder that goes with its object. One thread.

/// A folder in memory (writing back a disk's page may stall the lines), removed with this object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code error;
    const std::filesystem::path base = access("/dev/shm", W_OK) == 0
                                           ? std::filesystem::path("/dev/shm")
                                           : std::filesystem::temp_directory_path(error);
    std::string name = (base / "strobe-sim-XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code error;
    if (!path_.empty()) std::filesystem::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace strobe::sim
