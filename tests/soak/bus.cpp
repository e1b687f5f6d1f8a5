#include "tests/soak/bus.hpp"

#include <algorithm>

namespace strobe::soak {

namespace {

constexpr Duration kMin = microseconds(40);
constexpr Duration kMax = microseconds(120);
constexpr Duration kMaxReordered = milliseconds(60);

}  // namespace

std::uint32_t VirtualBus::free_packet() {
  if (free_.empty()) {
    packets_.push_back(std::make_unique<Packet>());
    return static_cast<std::uint32_t>(packets_.size() - 1);
  }
  const std::uint32_t packet = free_.back();
  free_.pop_back();
  return packet;
}

void VirtualBus::send(Receiver to, const std::string& channel, std::span<const std::uint8_t> bytes,
                      MonoTime now) {
  ++counts_.sent;
  if (faults_.loss > 0.0 && random_.chance(faults_.loss)) {
    ++counts_.lost;
    return;
  }
  const std::uint32_t index = free_packet();
  Packet& packet = *packets_[index];
  packet.channel = channel;
  packet.bytes.assign(bytes.begin(), bytes.end());
  fly(to, index, now);
  if (faults_.duplication > 0.0 && random_.chance(faults_.duplication)) {
    ++counts_.doubled;
    fly(to, index, now);
  }
}

void VirtualBus::fly(Receiver to, std::uint32_t packet, MonoTime now) {
  MonoTime at = now + random_.between(kMin, kMax);
  if (faults_.reordering > 0.0 && random_.chance(faults_.reordering)) {
    ++counts_.reordered;
    at = at + random_.between(Duration{}, kMaxReordered);
  } else {
    MonoTime& newest = newest_[static_cast<std::size_t>(to)];
    at = std::max(at, newest);
    newest = at;
  }
  ++packets_[packet]->in_flight;
  flights_.schedule(at, {to, packet});
}

VirtualBus::Delivery VirtualBus::take() {
  const auto flight = flights_.take();
  taken_ = flight.item.packet;
  return {flight.at, flight.item.to, packets_[taken_].get()};
}

void VirtualBus::done(const Delivery& delivery) {
  if (--delivery.packet->in_flight == 0) free_.push_back(taken_);
}

}  // namespace strobe::soak
