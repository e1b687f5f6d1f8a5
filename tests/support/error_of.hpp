// What is said against something, for tests that compare words.
#pragma once

#include <string>

namespace strobe::testing {

/// Of a Result; empty if it was accepted.
template <typename ResultType>
std::string error_of(const ResultType& result) {
  return result ? std::string() : result.error().message;
}

}  // namespace strobe::testing
