// A lab's key: 32 secret bytes. Who has them may command the lab's rigs. Kept in a file as 64 hexadecimal
// digits. Values, wiped when they end; thread-safe; not for the real-time path.
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
  /// 8 hexadecimal digits that tell keys apart and tell nothing about the key itself.
  std::string fingerprint() const;

 private:
  Key() = default;
  std::array<std::uint8_t, kBytes> bytes_{};
};

}  // namespace strobe::authentication
