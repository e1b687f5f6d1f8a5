#include "common/wire/assembler.hpp"

#include <algorithm>

namespace strobe::wire {

std::optional<Message> Assembler::take(std::uint64_t sender, std::span<const std::uint8_t> bytes) {
  const auto datagram = read_datagram(bytes);
  if (!datagram) return std::nullopt;
  if (datagram->parts == 1) return Message{datagram->channel, datagram->data};
  return datagram->message_bytes <= kMaxMessage_bytes ? add(sender, *datagram) : std::nullopt;
}

std::vector<Assembler::Unfinished>::iterator Assembler::find(std::uint64_t sender, const Datagram& part) {
  const auto known = std::find_if(unfinished_.begin(), unfinished_.end(), [&](const Unfinished& each) {
    return each.sender == sender && each.number == part.number && each.have.size() == part.parts &&
           each.data.size() == part.message_bytes;
  });
  if (known != unfinished_.end()) return known;
  if (unfinished_.size() == kMaxUnfinished) unfinished_.erase(unfinished_.begin());
  Unfinished fresh;
  fresh.sender = sender;
  fresh.number = part.number;
  fresh.data.resize(part.message_bytes);
  fresh.have.resize(part.parts);
  fresh.missing = part.parts;
  return unfinished_.insert(unfinished_.end(), std::move(fresh));
}

std::optional<Message> Assembler::add(std::uint64_t sender, const Datagram& part) {
  const auto at = find(sender, part);
  if (at->have[part.part]) return std::nullopt;  // twice
  at->have[part.part] = true;
  if (part.part == 0) at->channel = part.channel;
  std::copy(part.data.begin(), part.data.end(), at->data.begin() + part.at);
  if (--at->missing > 0) return std::nullopt;
  done_ = std::move(*at);
  unfinished_.erase(at);
  return Message{done_.channel, done_.data};
}

}  // namespace strobe::wire
