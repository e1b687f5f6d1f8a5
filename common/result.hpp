// Errors that a caller can act on. Thread-safe values; not for the real-time path (the message allocates).
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace strobe {

/// What went wrong, as one line that names the file, line, key or field concerned; no trailing newline.
struct Error {
  std::string message;
};

template <typename T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(std::string message) {
  return tl::unexpected<Error>(Error{std::move(message)});
}

}  // namespace strobe
