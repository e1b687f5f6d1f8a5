// Output lines on a /dev/gpiochipN.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/gpio/gpio_chip.hpp"
#include "firmware/ports/output_lines.hpp"

namespace strobe::firmware {

/// Requested once, before a fork: then both processes hold the same lines, and either can make them inactive
/// however the other ends. set(), set_lamps() and make_inactive() are real-time safe and async-signal-safe:
/// no allocation and no lock, one system call for each of kOutputs. One thread's but for make_inactive() in a
/// signal handler.
class GpioOutputs final : public OutputLines {
 public:
  /// Takes the rig's output lines, inactive from the start. Errors name the rig file's line and key.
  static Result<GpioOutputs> open(const Rig& rig);

  bool set(Output output, bool active) noexcept override;
  bool set_lamps(Lamps lamps) noexcept override;
  /// All of them, trigger first, whichever fail. Returns false if one did.
  bool make_inactive() noexcept;
  /// Likewise, and anew: where their pins had been given to another part of the chip, they are lines again.
  bool take_back() noexcept;
  /// This process's hold on the lines, which stay as they are; set() fails afterwards.
  void release() noexcept;

 private:
  explicit GpioOutputs(GpioChip chip) : chip_(std::move(chip)) {}

  GpioChip chip_;  // outlives its requests
  std::array<std::optional<OutputRequest>, kOutputs.size()> requests_;
};

/// The output lines of a rig, found but not yet requested: of a rig whose strobed is gone, or lost its own
/// lines.
class OutputTakeover {
 public:
  static Result<OutputTakeover> prepare(const Rig& rig);
  OutputTakeover(OutputTakeover&&) noexcept;
  OutputTakeover& operator=(OutputTakeover&&) noexcept;
  ~OutputTakeover();

  /// Requests every output as inactive, trigger first; retries a busy line for up to `patience`. The lines
  /// stay requested until destruction. Fails with the lines that could not be requested, and why.
  Result<void> drive_inactive(Duration patience);

 private:
  struct Impl;
  explicit OutputTakeover(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace strobe::firmware
