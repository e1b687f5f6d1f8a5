// Programs beside a running rig. strobe-sim operator: whoever stands at it while `strobe commission` asks for
// key, e-stop and wires.
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <thread>
#include <utility>

#include "sim/commands/commands.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/live/child_process.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

namespace {

constexpr int kBroken = -1;

struct Response {
  std::string_view asked;  ///< in the command's words
  RigLine line;
  int level;  ///< kBroken: its wire is pulled
};

constexpr std::array<Response, 12> kResponses{{{"waiting: the key is off", RigLine::key, 1},
                                               {"waiting: the e-stop is pressed", RigLine::estop, 1},
                                               {"have the key off", RigLine::key, 0},
                                               {"turn the key off", RigLine::key, 0},
                                               {"turn the key on", RigLine::key, 1},
                                               {"pull the wire of the key", RigLine::key, kBroken},
                                               {"key_wire: put the wire back", RigLine::key, 1},
                                               {"have the e-stop pressed", RigLine::estop, 0},
                                               {"press the e-stop", RigLine::estop, 0},
                                               {"release the e-stop", RigLine::estop, 1},
                                               {"pull the wire of the e-stop", RigLine::estop, kBroken},
                                               {"estop_wire: put the wire back", RigLine::estop, 1}}};

void obey(Chip& chip, std::string_view line) {
  for (const Response& response : kResponses) {
    if (line.find(response.asked) == line.npos) continue;
    const auto offset = static_cast<std::uint32_t>(response.line);
    if (response.level == kBroken)
      chip.open_wire(offset, chip.now());
    else
      chip.drive(offset, response.level, chip.now());
    return;
  }
}

/// What the command says goes on to standard error.
void listen(int said, Chip& chip) {
  std::array<char, 4096> bytes{};
  std::string line;
  for (ssize_t count = 0; (count = ::read(said, bytes.data(), bytes.size())) > 0 || errno == EINTR;) {
    if (count <= 0) continue;
    const std::string_view piece(bytes.data(), static_cast<std::size_t>(count));
    std::fwrite(piece.data(), 1, piece.size(), stderr);
    for (const char c : piece) {
      if (c != '\n') {
        line += c;
        continue;
      }
      obey(chip, line);
      line.clear();
    }
  }
}

}  // namespace

int operator_command(const std::string& chip_dir, const std::vector<std::string>& command) {
  auto chip = attach_to_rig(chip_dir);
  if (!chip) return report_error(chip.error().message, 2);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return report_error(std::string("pipe: ") + std::strerror(errno), 1);
  const int own = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  block_child_signals();
  dup2(ends[1], STDERR_FILENO);
  const auto child = start_joined(command, chip->dir(), [&chip] { chip->join_time(); });
  dup2(own, STDERR_FILENO);
  close(own);
  close(ends[1]);
  if (!child) {
    close(ends[0]);
    return report_error(child.error().message, 2);
  }
  std::thread listener([&] { listen(ends[0], *chip); });
  const int status = wait_for_child(*child);
  listener.join();
  close(ends[0]);
  return status;
}

int join_command(const std::string& chip_dir, const std::vector<std::string>& command) {
  const auto chip = attach_to_rig(chip_dir);
  if (!chip) return report_error(chip.error().message, 2);
  block_child_signals();
  const auto child = start_joined(command, chip->dir(), [&chip] { chip->join_time(); });
  return child ? wait_for_child(*child) : report_error(child.error().message, 2);
}

}  // namespace strobe::sim
