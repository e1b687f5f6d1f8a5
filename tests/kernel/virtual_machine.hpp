// An emulated arm64 computer on Debian's own kernel: QEMU with a PL061 GPIO chip whose eight lines the test
// drives and sees from outside, a shell on a serial line, and a network cable. Boots in some two seconds of
// an idle core. Failures are std::runtime_error. One thread for the shell, one for the lines.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/kernel/line_socket.hpp"
#include "tests/support/process.hpp"

namespace strobe::kernel {

inline constexpr unsigned kPins = 8;
inline constexpr std::chrono::seconds kTimeout{120};  ///< for what takes a second: the machine is emulated

class VirtualMachine {
 public:
  /// `boot` has vmlinuz, initrd and maybe a disk, which stays as it is (tests/kernel/prepare, unit/prepare);
  /// `folder` is for sockets and logs.
  VirtualMachine(const std::filesystem::path& boot, const std::filesystem::path& folder);
  ~VirtualMachine();

  /// The two ends of its network cable: datagram sockets for an LcmBridge.
  static std::filesystem::path cable_here(const std::filesystem::path& folder) {
    return folder / "cable-here";
  }
  static std::filesystem::path cable_there(const std::filesystem::path& folder) {
    return folder / "cable-there";
  }

  /// Runs a line of shell to its end and returns what it printed, its lines ended by "\n".
  std::string run(const std::string& line, std::chrono::milliseconds limit = kTimeout);

  struct PinChange {
    unsigned pin = 0;
    int level = 0;
  };
  /// What the kernel's driver does to its lines, in order; nothing if it did nothing in that time.
  std::optional<PinChange> next_change(std::chrono::milliseconds limit);
  /// Drives a line from outside. Changes that are reported meanwhile are kept for next_change.
  void drive(unsigned pin, int level);

  std::string log() const;  ///< all that came over the serial line

 private:
  std::string wait_for_line();
  std::string find_chip();
  std::string ask_lines(const std::string& command);
  void keep_change(const std::string& line);

  std::filesystem::path folder_;
  LineSocket serial_;
  LineSocket test_;
  LineSocket monitor_;
  std::string chip_;
  std::vector<PinChange> changes_;
  std::string log_;
  int commands_ = 0;
  std::unique_ptr<testing::Process> qemu_;
};

}  // namespace strobe::kernel
