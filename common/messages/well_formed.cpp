#include "common/messages/well_formed.hpp"

#include <cstdint>
#include <strobe_msgs/readout_t.hpp>

namespace strobe::messages {
namespace {

// Sizes of encoded fields, in the order of the .lcm files.
constexpr std::size_t kFingerprint = 8, kInt8 = 1, kInt32 = 4, kInt64 = 8, kDouble = 8;
constexpr std::size_t kPoint = 2 * kDouble;
constexpr std::size_t kBallImage = 2 * kInt8 + 12 * kDouble;
constexpr std::size_t kBallImageV1 = kInt8 + 6 * kDouble;
constexpr std::size_t kFlashV1 = kInt32 + 5 * kInt64 + kInt32;
constexpr std::size_t kFlash = kFlashV1 + kInt8;
constexpr std::size_t kMaxHistograms = 64;
constexpr std::size_t kHistogramHead = kInt8 + kInt64 + 9 * kDouble;
constexpr std::size_t kPlan = kInt8 + kInt64 + kInt32 + 3 * kInt64 + kInt8;  // of an even train
constexpr std::size_t kCodedFlash = kInt64 + kInt8;

/// Walks over an encoded message; once past its end it stays failed.
class Walk {
 public:
  Walk(const void* data, std::size_t size) : at_(static_cast<const unsigned char*>(data)), left_(size) {}

  void skip(std::size_t bytes) {
    if (bytes > left_) good_ = false;
    if (!good_) return;
    at_ += bytes;
    left_ -= bytes;
  }
  /// Its length counts the zero that ends it.
  void skip_string() {
    const std::size_t length = number();
    if (length < 1) good_ = false;
    skip(length);
  }
  std::int64_t integer() {
    if (left_ < kInt64) good_ = false;
    std::uint64_t value = 0;
    for (std::size_t i = 0; good_ && i < kInt64; ++i) value = value << 8 | at_[i];
    skip(kInt64);
    return static_cast<std::int64_t>(value);
  }
  /// A big-endian int32 that must not be negative.
  std::size_t number() {
    if (left_ < kInt32) good_ = false;
    if (!good_) return 0;
    const std::uint32_t value =
        std::uint32_t{at_[0]} << 24 | std::uint32_t{at_[1]} << 16 | std::uint32_t{at_[2]} << 8 | at_[3];
    skip(kInt32);
    if (value > 0x7FFFFFFF) good_ = false;
    return value;
  }
  /// A count of elements of that size, all of which must be there.
  void skip_elements(std::size_t element) {
    const std::size_t elements = number();
    if (good_ && elements > left_ / element) good_ = false;
    if (good_) skip(elements * element);
  }
  bool good() const { return good_; }
  bool at_end() const { return good_ && left_ == 0; }

 private:
  const unsigned char* at_;
  std::size_t left_;
  bool good_ = true;
};

bool frame_of(const void* data, std::size_t size, std::size_t host, std::size_t image) {
  Walk walk(data, size);
  walk.skip(kFingerprint + kInt32 + kInt64 + kInt32 + host);  // schema, boot, shot, host
  walk.skip_string();                                         // source
  walk.skip_string();                                         // photograph
  walk.skip(6 * kDouble);
  walk.skip_elements(kPoint);
  walk.skip_elements(image);
  return walk.at_end();
}

void skip_rest_of_shot(Walk& walk, std::size_t flash) {
  walk.skip(2 * kInt64 + kInt8);  // overflows, aborted
  walk.skip_string();             // reason
  walk.skip_elements(flash);
  const std::size_t notes = walk.number();
  for (std::size_t i = 0; i < notes && walk.good(); ++i) {
    walk.skip_string();
    walk.skip_string();
  }
}

}  // namespace

bool event_well_formed(const void* data, std::size_t size) {
  Walk walk(data, size);
  walk.skip(kFingerprint + kInt32 + 2 * kInt64 + kInt8 + kInt32);  // schema, boot, sequence, kind, shot
  walk.skip(4 * kInt64 + kInt32 + 2 * kInt8);                      // instants, flash, line, level
  walk.skip_string();
  return walk.at_end();
}

bool frame_well_formed(const void* data, std::size_t size) {
  return frame_of(data, size, kInt64, kBallImage);
}

bool frame_v1_well_formed(const void* data, std::size_t size) {
  return frame_of(data, size, 0, kBallImageV1);
}

bool status_well_formed(const void* data, std::size_t size) {
  Walk walk(data, size);
  walk.skip(kFingerprint + kInt32 + 5 * kInt64 + 3 * kInt8);  // schema, boot, sequence, clocks, state, inputs
  walk.skip(3 * kInt64 + kInt32 + 2 * kInt8 + 8 * kInt64);    // arming, last shot, health, losses, rejected
  walk.skip_elements(2 * kInt64);                             // earlier starts
  const std::size_t histograms = walk.number();
  if (histograms > kMaxHistograms) return false;
  for (std::size_t i = 0; i < histograms && walk.good(); ++i) {
    walk.skip(kHistogramHead);
    walk.skip_elements(kInt64);
  }
  walk.skip_string();
  return walk.at_end();
}

bool status_v1_well_formed(const void* data, std::size_t size) {
  Walk walk(data, size);
  walk.skip(kFingerprint + kInt32 + 4 * kInt64 + 3 * kInt8);  // schema, boot, sequence, clocks, state, inputs
  walk.skip(3 * kInt64 + kInt32 + 2 * kInt8);                 // arming, last shot, health
  walk.skip(3 * kInt64 + 4 * kDouble);                        // losses, lateness
  walk.skip_string();
  return walk.at_end();
}

bool shot_well_formed(const void* data, std::size_t size) {
  Walk walk(data, size);
  walk.skip(kFingerprint + kInt32 + kInt64 + kInt32 + 3 * kInt64);  // schema, boot, shot, host, sequences
  walk.skip(kPlan);
  walk.skip_elements(kCodedFlash);
  walk.skip(5 * kInt64 + kInt8 + 2 * kInt64);    // start and shutter, its feedback, trigger and gate
  walk.skip(2 * kDouble + 2 * kInt8 + kDouble);  // lamp delays, sensors, tolerance
  skip_rest_of_shot(walk, kFlash);
  return walk.at_end();
}

bool shot_v1_well_formed(const void* data, std::size_t size) {
  Walk walk(data, size);
  walk.skip(kFingerprint + kInt32 + kInt64 + kInt32 + 3 * kInt64);
  walk.skip(kPlan);
  walk.skip(5 * kInt64 + kDouble + 2 * kInt8 + kDouble);  // instants, lamp delay, sensors, tolerance
  skip_rest_of_shot(walk, kFlashV1);
  return walk.at_end();
}

std::int64_t readout_host(const void* data, std::size_t size) {
  Walk walk(data, size);
  const bool is_readout = walk.integer() == strobe_msgs::readout_t::getHash();
  walk.skip(kInt32);  // schema
  const std::int64_t host = walk.integer();
  return is_readout && walk.good() ? host : 0;
}

}  // namespace strobe::messages
