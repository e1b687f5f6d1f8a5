// Text in a buffer of its own: no allocation, cut off when full. Real-time safe; a plain value.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace strobe::firmware {

template <std::size_t Capacity>
class TruncatingString {
 public:
  TruncatingString() = default;
  TruncatingString(std::string_view text) noexcept { append(text); }  // NOLINT: text is meant to convert
  TruncatingString(const char* text) noexcept { append(text); }       // NOLINT

  TruncatingString& append(std::string_view text) noexcept {
    const std::size_t taken = std::min(text.size(), Capacity - size_);
    std::copy_n(text.data(), taken, text_.data() + size_);
    size_ += taken;
    return *this;
  }
  TruncatingString& append(std::int64_t number, int base = 10) noexcept {
    std::array<char, 72> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number, base).ptr;
    return append(std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
  }
  std::string_view view() const noexcept { return {text_.data(), size_}; }
  bool empty() const noexcept { return size_ == 0; }
  bool operator==(const TruncatingString& other) const noexcept { return view() == other.view(); }

 private:
  std::array<char, Capacity> text_{};
  std::size_t size_ = 0;
};

using ShortText = TruncatingString<160>;  ///< one line for a person

}  // namespace strobe::firmware
