// Edge source on a /dev/gpiochipN.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/edge_source.hpp"

namespace strobe::firmware {

/// wait(), poll() and level() are real-time safe: no allocation, one system call per level. One thread's.
class GpioInputs final : public EdgeSource {
 public:
  /// Takes every input of the rig. wake_fd: an eventfd that ends wait(), emptied there.
  /// Errors name the rig file's line and key.
  static Result<std::unique_ptr<GpioInputs>> open(const Rig& rig, int wake_fd);
  ~GpioInputs() override;

  /// What was put up with when the lines were taken: inputs whose broken wire would not stop the rig. One
  /// line each.
  const std::vector<std::string>& warnings() const;

  std::optional<std::size_t> wait(MonoTime until, std::span<Edge> edges) noexcept override;
  std::optional<std::size_t> poll(MonoTime until, std::span<Edge> edges) noexcept override;
  std::optional<bool> level(Input input) noexcept override;
  std::int64_t kernel_overflows() const noexcept override;

 private:
  struct Impl;
  explicit GpioInputs(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace strobe::firmware
