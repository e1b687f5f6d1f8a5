// A value, or why a request cannot be answered. Plain values.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace strobe::web {

struct Unanswered {
  int status = 500;   ///< of HTTP: 404, 409, 422, 500
  std::string words;  ///< one line
};

template <typename T>
using Answered = tl::expected<T, Unanswered>;

inline tl::unexpected<Unanswered> unanswered(int status, std::string words) {
  return tl::unexpected<Unanswered>(Unanswered{status, std::move(words)});
}

}  // namespace strobe::web
