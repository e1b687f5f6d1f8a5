// Walks over an encoded LCM message without decoding it (big-endian; LCM's documentation, "LCM Type
// Specification"). Once past the message's end, or at a count out of bounds, it stays failed. Pure.
#pragma once

#include <cstddef>
#include <cstdint>

namespace strobe::messages {

class EncodedWalk {
 public:
  static constexpr std::size_t kFingerprint_bytes = 8;

  EncodedWalk(const void* data, std::size_t size)
      : at_(static_cast<const unsigned char*>(data)), left_(size) {}

  void skip(std::size_t bytes) {
    if (bytes > left_) good_ = false;
    if (!good_) return;
    at_ += bytes;
    left_ -= bytes;
  }
  void skip_elements(std::size_t count, std::size_t element_bytes) {
    if (count > left_ / element_bytes) good_ = false;
    if (good_) skip(count * element_bytes);
  }
  /// A string's length counts the zero that ends it.
  void skip_string() {
    const std::int64_t length = integer(4);
    if (length < 1) good_ = false;
    if (good_) skip(static_cast<std::size_t>(length));
  }
  /// A count of elements; 0 and failed unless it is within [0, most].
  std::size_t count(std::int64_t most) {
    const std::int64_t value = integer(4);
    if (value < 0 || value > most) good_ = false;
    return good_ ? static_cast<std::size_t>(value) : 0;
  }
  /// A signed integer of so many bytes; 0 if it has failed.
  std::int64_t integer(std::size_t bytes) {
    if (bytes > left_) good_ = false;
    if (!good_) return 0;
    std::uint64_t value = (at_[0] & 0x80U) != 0 ? ~std::uint64_t{0} : 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | at_[i];
    skip(bytes);
    return static_cast<std::int64_t>(value);
  }
  bool good() const { return good_; }
  bool at_end() const { return good_ && left_ == 0; }

 private:
  const unsigned char* at_;
  std::size_t left_;
  bool good_ = true;
};

}  // namespace strobe::messages
