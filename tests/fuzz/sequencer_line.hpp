// A flash sequencer's line out of a fuzzer's input. Records of a size, two bytes, and so many more: a frame's body after
// its kind and number, sent undamaged, which no fuzzer would find by itself; with a size of 255 bytes as they are, as
// many as the first of the two says.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "common/flash_sequencer/protocol.hpp"

namespace strobe::fuzz {

inline std::vector<std::uint8_t> sequencer_line(std::span<const std::uint8_t> input) {
  using namespace flash_sequencer;
  std::vector<std::uint8_t> line;
  while (input.size() >= 3) {
    const bool raw = input[0] == 255;
    const std::size_t asked = raw ? input[1] : std::min<std::size_t>(input[0], kMaxBody);
    Frame frame;
    frame.kind = input[1];
    frame.number = input[2];
    const auto bytes = input.subspan(3, std::min(asked, input.size() - 3));
    input = input.subspan(3 + bytes.size());
    if (raw) {
      line.insert(line.end(), bytes.begin(), bytes.end());
      continue;
    }
    frame.size = static_cast<std::uint8_t>(bytes.size());
    std::ranges::copy(bytes, frame.body.begin());
    std::array<std::uint8_t, kMaxFrame> wire;
    const std::size_t size = encode(frame, wire);
    line.insert(line.end(), wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(size));
  }
  return line;
}

}  // namespace strobe::fuzz
