// What a protocol computes from shots, number by number. Part of the evaluation, not of its interface. Not
// thread-safe per object; allocates.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/protocol/evaluation.hpp"
#include "host/protocol/number.hpp"
#include "host/protocol/protocol.hpp"

namespace strobe::protocol {

/// A shot that counts.
struct CountedShot {
  Cell cell;
  const host::Shot* shot = nullptr;
};

/// One computed number of one shot, ball, position or of the test.
struct ComputedNumber {
  Cell cell;         ///< empty above its level
  std::string shot;  ///< level shot only
  Result<Number> number;
};

/// By the place in Protocol::computed.
struct ComputedNumbers {
  Sources sources;
  std::vector<std::vector<ComputedNumber>> of;
};

ComputedNumbers compute(const Protocol& protocol, const std::vector<CountedShot>& shots);

}  // namespace strobe::protocol
