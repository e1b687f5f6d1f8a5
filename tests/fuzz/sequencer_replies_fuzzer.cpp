// What a flash sequencer, or whatever is at the other end of its cable, sends: any bytes are replies whose values stand for
// something, or are dropped. Input: sequencer_line.hpp's.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "common/flash_sequencer/protocol.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/fuzz/sequencer_line.hpp"

namespace {

using namespace strobe::flash_sequencer;

void require_same(const Frame& one, const Frame& other) {
  strobe::fuzz::require(one.kind == other.kind && std::ranges::equal(one.bytes(), other.bytes()));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Decoder decoder;
  for (const std::uint8_t byte : strobe::fuzz::sequencer_line({data, size})) {
    const Frame* frame = decoder.take(byte);
    if (frame == nullptr) continue;
    if (const auto identity = read_identity(*frame)) require_same(*frame, to_frame(*identity));
    if (const auto edge = read_input(*frame)) require_same(*frame, to_frame(*edge));
    if (const auto status = read_status(*frame)) {
      strobe::fuzz::require(status->answers >= Request::hello && status->answers <= Request::reset);
      require_same(*frame, to_frame(*status));
    }
  }
  return 0;
}
