// Datagrams as an application sends them, written down from the standard's figures and not by the camera's code.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <vector>

namespace strobe::testing {

using Datagram = std::vector<std::uint8_t>;

inline void add_words(Datagram& datagram, std::initializer_list<std::uint32_t> words) {
  for (const std::uint32_t word : words)
    for (const int shift : {24, 16, 8, 0}) datagram.push_back(static_cast<std::uint8_t>(word >> shift));
}

/// Key, acknowledge wanted, command, length, id, data.
inline Datagram gvcp(std::uint16_t command, std::initializer_list<std::uint32_t> words, std::uint16_t id = 7) {
  const auto high = [](std::uint32_t number) { return static_cast<std::uint8_t>(number >> 8); };
  const auto low = [](std::uint32_t number) { return static_cast<std::uint8_t>(number); };
  const auto length = static_cast<std::uint32_t>(4 * words.size());
  Datagram datagram{0x42, 0x01, high(command), low(command), high(length), low(length), high(id), low(id)};
  add_words(datagram, words);
  return datagram;
}

inline Datagram read_register(std::uint32_t address) { return gvcp(0x0080, {address}); }
inline Datagram write_register(std::uint32_t address, std::uint32_t value) {
  return gvcp(0x0082, {address, value});
}

inline std::uint32_t word_of(const Datagram& datagram, std::size_t at) {
  return static_cast<std::uint32_t>(datagram.at(at)) << 24 | static_cast<std::uint32_t>(datagram.at(at + 1)) << 16 |
         static_cast<std::uint32_t>(datagram.at(at + 2)) << 8 | datagram.at(at + 3);
}

}  // namespace strobe::testing
