// How many packets of the command channel were rejected since the start, by reason. A plain value.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/authentication/rejection.hpp"

namespace strobe::firmware {

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

}  // namespace strobe::firmware
