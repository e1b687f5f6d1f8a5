// Sealed telemetry: the packet on a channel is the encoded LCM message and behind it a seal of fixed size.
// LCM's generated decoders ignore what follows a message, so that everybody's tools still read it.
//
// The seal, numbers big-endian: 8 bytes "STROBES1"; the key's fingerprint, 4 bytes; the sender, 8 bytes (a
// firmware's boot id, a host's id); the sender's number of the packet, 8 bytes; 16 bytes of keyed BLAKE2b
// (RFC 7693) of sender, number, the channel's size (2 bytes), the channel, which names the rig, and the
// message. The size keeps one packet's parts from being read as another's. No more is hashed than must be,
// since most events then fit one block of the hash. The first two fields are what a host expects, or the
// packet is not opened.
//
// Pure; allocates; thread-safe; not for the real-time path.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/authentication/unverified.hpp"

namespace strobe::authentication {

using Bytes = std::span<const std::uint8_t>;

inline constexpr std::size_t kSealHeader_bytes = 8 + 4 + 8 + 8;
inline constexpr std::size_t kPacketSeal_bytes = kSealHeader_bytes + 16;

/// Which of its packets a sender sealed. No two packets of a sender have the same number.
struct PacketNumber {
  std::int64_t sender = 0;
  std::int64_t sequence = 0;
};

/// The lab's key for one end of its packets.
class PacketSeal {
 public:
  explicit PacketSeal(const Key& key);

  /// Message and seal. channel: below 65,536 bytes; LCM allows 63.
  std::vector<std::uint8_t> seal(std::string_view channel, Bytes message, const PacketNumber& number) const;

  struct Opened {
    Bytes message;  ///< a part of the packet
    PacketNumber number;
  };
  /// Fails with unsealed, other_key or altered, checked in this order. Valid: any bytes. Takes a time that
  /// depends on the sizes alone, not on how much of a forged seal is right.
  tl::expected<Opened, Unverified> open(std::string_view channel, Bytes packet) const;

 private:
  Key key_;
  std::uint32_t fingerprint_;
};

/// A packet without its seal, whoever sealed it; a packet without one as it is.
Bytes message_of(Bytes packet);

}  // namespace strobe::authentication
