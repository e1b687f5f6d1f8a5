// Checks of messages from outside, generated from the .lcm files (generate_checks.cmake). LCM's generated
// decoders trust a message: they allocate as many elements as it claims (250 million images would take 16 GB)
// and read two gigabytes, or throw, for a string whose length is below 1. So every count and length is
// checked before a message is decoded. Pure functions; thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace strobe_msgs {
class frame_t;
}  // namespace strobe_msgs

namespace strobe::messages {

/// True if the encoded message is exactly as long as its own counts and lengths say, and every count is
/// within the range that the .lcm file gives. The fingerprint is the decoder's to check. For every type of
/// the .lcm files.
template <typename Message>
bool well_formed(const void* data, std::size_t size);

/// True if every number of a decoded message, those of its parts included, is within the range that the .lcm
/// file gives: far enough from overflow to be calculated with. Not whether it is true.
template <typename Message>
bool in_range(const Message& message);

/// Decodes a well-formed message. Returns false if it is not, or if it is of another type.
template <typename Message>
bool decode_checked(Message& message, const void* data, std::size_t size) {
  return size <= static_cast<std::size_t>(std::numeric_limits<int>::max()) &&
         well_formed<Message>(data, size) && message.decode(data, 0, static_cast<int>(size)) >= 0;
}

/// Of a frame, too, that was written before it had shared_diameter_sd_px (frame_4_t), or its images a
/// probability (frame_3_t) or a tilt (frame_2_t): they have none then.
bool decode_checked(strobe_msgs::frame_t& frame, const void* data, std::size_t size);

/// The host_id of an encoded readout_t, read without decoding its lists; 0 if it is not a readout.
std::int64_t readout_host(const void* data, std::size_t size);

// An LCM message as bytes. Pure; thread-safe; allocates.

template <typename Message>
std::vector<std::uint8_t> encode(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace strobe::messages
