// Assembles messages from datagrams of one or several parts. Whatever arrives, it holds at most a few
// unfinished messages of bounded size. One thread's; allocates only for messages of several parts.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/wire/lcm_datagram.hpp"

namespace strobe::wire {

struct Message {
  std::string_view channel;
  std::span<const std::uint8_t> data;
};

class Assembler {
 public:
  static constexpr std::uint32_t kMaxMessage_bytes = 1 << 20;
  static constexpr std::size_t kMaxUnfinished = 8;  ///< the oldest is dropped

  /// The message that this datagram is or completes, valid until the next call and as long as `bytes`;
  /// nullopt if there is none. sender: identifies the sender.
  std::optional<Message> take(std::uint64_t sender, std::span<const std::uint8_t> bytes);

 private:
  struct Unfinished {
    std::uint64_t sender = 0;
    std::uint32_t number = 0;
    std::string channel;
    std::vector<std::uint8_t> data;
    std::vector<bool> have;  ///< by part
    std::size_t missing = 0;
  };
  std::optional<Message> add(std::uint64_t sender, const Datagram& part);
  std::vector<Unfinished>::iterator find(std::uint64_t sender, const Datagram& part);

  std::vector<Unfinished> unfinished_;  ///< oldest first
  Unfinished done_;
};

}  // namespace strobe::wire
