// Packets of the command channel that were rejected: how many since the start, by reason, and a line now and
// then.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "common/authentication/rejection.hpp"
#include "firmware/ports/clock.hpp"

namespace strobe::firmware {

/// By reason. A plain value.
struct RejectedCommands {
  std::array<std::int64_t, authentication::kRejectionCount> counts{};  ///< in the order of Rejection

  std::int64_t& operator[](authentication::Rejection why) noexcept {
    return counts[static_cast<std::size_t>(why)];
  }
  std::int64_t operator[](authentication::Rejection why) const noexcept {
    return counts[static_cast<std::size_t>(why)];
  }
  bool operator==(const RejectedCommands&) const = default;
};

/// Counts rejected commands and logs them at a limited rate: the first at once, then at most one line in ten
/// seconds. Counts may be read on any thread; all else is one thread's.
class Rejections {
 public:
  using Say = std::function<void(const std::string&)>;
  static constexpr Duration kQuiet = milliseconds(10'000);

  /// say: a line for a person; must not wait.
  Rejections(Clock& clock, Say say) : clock_(clock), say_(std::move(say)) {}

  void note(authentication::Rejection why);
  /// A line about a command that was lost.
  void tell(const std::string& line) { say_(line); }
  /// Logs what was held back, when it may. Call it now and then.
  void turn();

  /// Since start.
  std::int64_t count(authentication::Rejection why) const noexcept {
    return counts_[static_cast<std::size_t>(why)].load(std::memory_order_relaxed);
  }
  RejectedCommands counts() const noexcept;

 private:
  std::string words() const;

  Clock& clock_;
  Say say_;
  std::array<std::atomic<std::int64_t>, authentication::kRejectionCount> counts_{};
  RejectedCommands said_;
  bool held_back_ = false;
  MonoTime quiet_until_{};
};

}  // namespace strobe::firmware
