// A flash sequencer's line on a terminal device: 1,000,000 baud, 8 bits, no parity, one stop bit, no flow
// control.
#pragma once

#include <atomic>
#include <memory>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/flash_sequencer/serial_line.hpp"

namespace strobe::firmware {

/// Opened before a fork, both processes may write.
class TtyLine final : public SerialLine {
 public:
  /// Takes the rig's for this process and those that it forks; whatever has come is thrown away. Errors name
  /// the rig file's line and key.
  static Result<std::unique_ptr<TtyLine>> open(const Rig& rig);
  TtyLine(const TtyLine&) = delete;
  TtyLine& operator=(const TtyLine&) = delete;
  ~TtyLine() override;

  /// An eventfd that ends wait(), emptied there.
  void set_wake(int wake_fd) { wake_fd_ = wake_fd; }
  /// This process's hold on the device: all calls fail afterwards.
  void release() noexcept;

  bool write(std::span<const std::uint8_t> bytes) noexcept override;
  std::optional<Departure> departure(std::int64_t bytes, MonoTime before, MonoTime after) noexcept override;
  std::optional<std::size_t> read(std::span<std::uint8_t> bytes) noexcept override;
  bool wait(MonoTime until) noexcept override;
  bool poll(MonoTime until) noexcept override;

 private:
  explicit TtyLine(int fd) : fd_(fd) {}

  std::atomic<int> fd_;  // the heartbeat's thread writes while the loop's may release it
  int wake_fd_ = -1;
};

}  // namespace strobe::firmware
