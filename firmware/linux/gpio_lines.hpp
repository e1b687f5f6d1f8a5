// Output lines and edge source on a /dev/gpiochipN, and what the guardian needs of it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/edge_source.hpp"
#include "firmware/ports/output_lines.hpp"

namespace strobe::firmware {

/// Both ports. set(), wait(), poll() and level() are real-time safe: no allocation, one system call per set and
/// level.
class GpioLines final : public OutputLines, public EdgeSource {
 public:
  /// Takes every line of the rig, outputs inactive. wake_fd: an eventfd that ends wait(), emptied there.
  /// Errors name the rig file's line and key.
  static Result<std::unique_ptr<GpioLines>> open(const Rig& rig, int wake_fd);
  ~GpioLines() override;

  /// What was put up with when the lines were taken: inputs whose broken wire would not stop the rig. One line each.
  const std::vector<std::string>& warnings() const;

  bool set(Output output, bool active) noexcept override;
  bool set_lamps(Lamps lamps) noexcept override;
  /// Releases the output lines, as they are, so that the guardian can take them; set() fails afterwards.
  void release_outputs() noexcept;
  std::optional<std::size_t> wait(MonoTime until, std::span<Edge> edges) noexcept override;
  std::optional<std::size_t> poll(MonoTime until, std::span<Edge> edges) noexcept override;
  std::optional<bool> level(Input input) noexcept override;
  std::int64_t kernel_overflows() const noexcept override;

 private:
  struct Impl;
  explicit GpioLines(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// The output lines of a rig, found but not yet requested, so that they can be taken at once.
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
