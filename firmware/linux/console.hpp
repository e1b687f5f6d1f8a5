// Lines on standard error from threads that must not wait for whoever reads them: a terminal that Ctrl-S has
// stopped or a pipe that nobody empties blocks every write. A thread of the console's own writes; what finds
// no room meanwhile is counted, and told once writing goes on. Not real-time (a mutex, an allocation); any
// thread.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

namespace strobe::firmware {

class Console {
 public:
  /// So many lines wait at most, each cut off after kLongestLine bytes: 0.3 MB.
  static constexpr std::size_t kMaxLines = 256;
  static constexpr std::size_t kLongestLine = 1024;

  /// fd: standard error; tests give others. Where no thread can be had, lines are written while they find
  /// room.
  explicit Console(int fd = 2);
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;
  /// Waits half a second at most for what is left to be written.
  ~Console();

  /// Writes the line after the program's name, soon. Never waits for the reader.
  void say(std::string_view line) noexcept;

 private:
  struct State;
  static void write_lines(const std::shared_ptr<State>& state);

  bool has_writer_ = true;
  std::shared_ptr<State> state_;  ///< the writer's, too: it may never come back from a write
};

}  // namespace strobe::firmware
