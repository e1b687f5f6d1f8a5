// The pseudo terminal at which a program finds the simulated flash sequencer, raw, at a path of the rig's.
// One thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "common/result.hpp"
#include "sim/gpiochip/chip.hpp"

namespace strobe::sim::sequencer {

class Terminal {
 public:
  /// `path` becomes a link to it, until this object ends. Rig time waits for what programs write to it;
  /// `chip` must outlive this.
  static Result<Terminal> open(const std::filesystem::path& path, Chip& chip);
  Terminal(Terminal&& other) noexcept;
  Terminal& operator=(Terminal&&) = delete;
  ~Terminal();

  int descriptor() const { return written_; }  ///< to be polled
  /// What a program wrote at once, and when, however late it is read: the oldest that has come.
  struct Written {
    MonoTime at;
    std::vector<std::uint8_t> bytes;
  };
  std::optional<Written> read();
  /// What the program does not take is lost, as at a serial line.
  void write(std::span<const std::uint8_t> bytes);

 private:
  Terminal(Chip& chip, std::filesystem::path path) : chip_(chip), path_(std::move(path)) {}
  Result<void> make();

  Chip& chip_;
  std::filesystem::path path_;
  int written_ = -1;  ///< a FIFO, see write_to_terminal()
  int master_ = -1;
  int slave_ = -1;  ///< kept open, so that the line does not end with the program
};

}  // namespace strobe::sim::sequencer
