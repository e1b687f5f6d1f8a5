// A GPIO chip and requests of its lines, over whichever libgpiod there is: gpio_chip_v1.cpp is written
// for 1.6, whose events have no sequence number and whose kernel buffer holds 16 edges of a line, the newest
// lost first; gpio_chip_v2.cpp for 2, with one buffer for all inputs, the oldest lost first, and counted.
// Chosen when the build is configured. Levels are logical: active or not. One thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "common/units/time.hpp"
#include "firmware/core/rig.hpp"

namespace strobe::firmware {

struct InputLineSpec {
  unsigned offset = 0;
  bool active_low = false;
  bool both_edges = false;  ///< else only those to active
  Bias bias = Bias::as_is;
};

/// Why lines could not be requested.
struct RequestFailure {
  int error = 0;         ///< as errno
  std::size_t line = 0;  ///< of those asked for, the one that is to blame as far as that can be known
};

/// Output lines, held until destruction, which leaves them as they are; active is high. A fork shares them:
/// they are held as long as one of the processes holds them.
class OutputRequest {
 public:
  /// One level for each line, in one system call. Returns false if it failed. Real-time safe and
  /// async-signal-safe.
  bool set(std::span<const bool> active) noexcept;
  /// Makes them outputs once more, inactive, as at the request: a pin that was given to another part of the
  /// chip meanwhile is the line's again. Likewise.
  bool take_back() noexcept;

  OutputRequest(OutputRequest&&) noexcept;
  OutputRequest& operator=(OutputRequest&&) noexcept;
  ~OutputRequest();

 private:
  friend class GpioChip;
  struct Impl;
  explicit OutputRequest(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

struct LineEdge {
  std::size_t line = 0;  ///< of the specs
  MonoTime time;         ///< the kernel's stamp
  bool active = false;   ///< level after the edge
};

/// Input lines, held until destruction.
class InputRequest {
 public:
  /// What to poll for; each stays the same while the request lasts.
  std::span<const int> descriptors() const noexcept;
  /// Takes edges, in order of time, from a descriptor that is readable, as many as there are and fit. Returns
  /// nullopt if it cannot be read, as of a chip that was removed. Real-time safe.
  std::optional<std::size_t> read(std::size_t descriptor, std::span<LineEdge> edges) noexcept;
  /// Level now; nullopt if it cannot be read. Real-time safe.
  std::optional<bool> level(std::size_t line) noexcept;
  /// Edges that the kernel is known to have lost (2), or how often a buffer was found full, so that some may
  /// have been (1.6).
  std::int64_t overflows() const noexcept;

  InputRequest(InputRequest&&) noexcept;
  InputRequest& operator=(InputRequest&&) noexcept;
  ~InputRequest();

 private:
  friend class GpioChip;
  struct Impl;
  explicit InputRequest(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

class GpioChip {
 public:
  /// By path ("/dev/gpiochip0"), name ("gpiochip0"), number ("0") or label. Fails with an errno.
  static tl::expected<GpioChip, int> open(const std::string& which);
  GpioChip(GpioChip&&) noexcept;
  GpioChip& operator=(GpioChip&&) noexcept;
  ~GpioChip();

  std::string name() const;
  unsigned line_count() const;
  /// The first line of that name; nullopt if there is none.
  std::optional<unsigned> find_line(const std::string& name) const;
  /// Who uses a line, "" if that is not told; nullopt if nobody does.
  std::optional<std::string> user_of(unsigned offset) const;
  /// What the kernel was asked for with the line's request; it tells so even of a chip that has no such
  /// resistor.
  Bias bias_of(unsigned offset) const;

  /// Drives the lines, by offset, low from the very start. At least one line, at most 64.
  tl::expected<OutputRequest, RequestFailure> request_outputs(std::span<const unsigned> offsets);
  tl::expected<InputRequest, RequestFailure> request_inputs(std::span<const InputLineSpec> lines);

 private:
  struct Impl;
  explicit GpioChip(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace strobe::firmware
