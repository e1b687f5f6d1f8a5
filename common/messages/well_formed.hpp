// Whether an encoded message may be given to its generated decoder, which believes what a message says: it
// makes room for as many elements as are claimed (250 million images would take 16 GB), and reads two
// gigabytes, or throws, for a text whose length is below 1. Every count and length is walked through first.
// Fields' values are the caller's to judge. Pure functions; thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

namespace strobe::messages {

/// True if the bytes are exactly as long as their own counts and lengths say. The fingerprint is the
/// decoder's to check.
bool event_well_formed(const void* data, std::size_t size);
bool frame_well_formed(const void* data, std::size_t size);
bool frame_v1_well_formed(const void* data, std::size_t size);
bool status_well_formed(const void* data, std::size_t size);
bool status_v1_well_formed(const void* data, std::size_t size);
bool shot_well_formed(const void* data, std::size_t size);
bool shot_v1_well_formed(const void* data, std::size_t size);

/// Decodes a message that its function above finds well formed. False: it is not, or is of another type.
template <typename Message>
bool decode_checked(Message& message, bool (*well_formed)(const void*, std::size_t), const void* data,
                    std::size_t size) {
  return size <= static_cast<std::size_t>(std::numeric_limits<int>::max()) && well_formed(data, size) &&
         message.decode(data, 0, static_cast<int>(size)) >= 0;
}

/// Who computed an encoded readout, from its head alone: its lists are never decoded. 0: not a readout.
std::int64_t readout_host(const void* data, std::size_t size);

}  // namespace strobe::messages
