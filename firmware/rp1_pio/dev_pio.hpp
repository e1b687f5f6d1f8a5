// The PIO block of a Raspberry Pi 5 by its device, /dev/pio0: requests of Linux's rp1-pio driver
// (drivers/misc/rp1-pio.c and include/uapi/misc/rp1_pio_if.h of raspberrypi/linux). The machines are not
// claimed: the driver stops claimed ones when the device is closed, watchers too. So a program that does not
// ask whether the device is locked (flock(2)) can take them.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/rp1_pio/pio_block.hpp"

namespace strobe::firmware {

/// A transfer's request sleeps until it is over, so that threads of its own make it.
class DevPio final : public PioBlock {
 public:
  /// ioctl(2), or what stands in for it.
  using Ioctl = int (*)(int fd, unsigned long request, void* argument);

  /// Takes the rig's block for this process and its children, and for no other strobed. Errors name the rig
  /// file's line, and say what to do.
  static Result<std::unique_ptr<DevPio>> open(const Rig& rig);
  /// fd is closed in the end.
  DevPio(int fd, Ioctl ioctl) : fd_(fd), ioctl_(ioctl) {}
  DevPio(const DevPio&) = delete;
  DevPio& operator=(const DevPio&) = delete;
  ~DevPio() override { release(); }

  /// Empty, or why its machines cannot be used.
  std::string in_use();
  /// Starts the threads of transfers: before the first of them, in the process that asks for them.
  void start(int priority);
  /// This process's hold on it.
  void release() noexcept;

  bool load(std::span<const std::uint16_t> program) noexcept override;
  bool set_up(unsigned machine, const Registers& registers, unsigned address) noexcept override;
  bool execute(unsigned machine, std::uint16_t instruction) noexcept override;
  bool enable(unsigned machines) noexcept override;
  bool disable(unsigned machines) noexcept override;
  bool drive(unsigned pin) noexcept override;
  std::optional<std::uint32_t> get(unsigned machine) noexcept override;
  /// Valid: to the machines below kTransfers, up to kMaxWords.
  bool transfer(unsigned machine, std::span<const std::uint32_t> words) noexcept override;
  bool transferring(unsigned machine) noexcept override;
  std::optional<unsigned> queued(unsigned machine) noexcept override;

  static constexpr std::size_t kTransfers = 2;
  static constexpr std::size_t kMaxWords = 4096;

 private:
  enum class Task : std::uint8_t { none, asked, stop };
  /// A machine's thread, and what it is to transfer.
  struct Mover {
    std::atomic<Task> task{Task::none};
    std::span<const std::uint32_t> words;
    std::atomic<bool> outlasted{false};  ///< a request has ended before its transfer
    bool configured = false;
    std::thread thread;
  };

  template <typename Arguments>
  bool ask(unsigned long request, Arguments& arguments) const noexcept {
    return ioctl_(fd_, request, &arguments) >= 0;
  }
  void move(unsigned machine, int priority) noexcept;
  bool begun(unsigned machine, std::size_t words) noexcept;

  std::atomic<int> fd_;
  Ioctl ioctl_;
  std::array<Mover, kTransfers> movers_;
};

}  // namespace strobe::firmware
