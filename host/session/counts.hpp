// Whether the counts in an encoded message can be true. The generated decoders make room for as many elements
// as a message claims before they look for them: 250 million images would take 16 GB. Pure functions;
// thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>

namespace strobe::host {

/// False if a count is negative or claims more elements than the bytes behind it can hold. What else may be
/// wrong is the decoder's to find.
bool frame_counts_plausible(const void* data, std::size_t size);
bool frame_v1_counts_plausible(const void* data, std::size_t size);
bool status_counts_plausible(const void* data, std::size_t size);
bool shot_counts_plausible(const void* data, std::size_t size);
bool shot_v1_counts_plausible(const void* data, std::size_t size);

/// Who computed an encoded readout, from its head alone: its lists are never decoded. 0: not a readout.
std::int64_t readout_host(const void* data, std::size_t size);

}  // namespace strobe::host
