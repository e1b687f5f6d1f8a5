// A lab's key: 32 secret bytes that authorize commands to the lab's rigs, kept in a file as 64 hexadecimal
// digits. Values, wiped by their destructor; thread-safe; not for the real-time path.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe::authentication {

class Key {
 public:
  static constexpr std::size_t kBytes = 32;

  /// From the kernel's generator.
  static Key random();
  /// 64 hexadecimal digits; blanks and line ends after them are allowed. The error does not quote the text.
  static Result<Key> from_text(std::string_view text);

  Key(const Key&) = default;
  Key& operator=(const Key&) = default;
  ~Key();

  std::span<const std::uint8_t, kBytes> bytes() const { return bytes_; }
  /// 64 hexadecimal digits.
  std::string text() const;
  /// 8 hexadecimal digits that identify a key without revealing it.
  std::string fingerprint() const;

 private:
  Key() = default;
  std::array<std::uint8_t, kBytes> bytes_{};
};

}  // namespace strobe::authentication
