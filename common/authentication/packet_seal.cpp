#include "common/authentication/packet_seal.hpp"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string>

#include "common/authentication/big_endian.hpp"

namespace strobe::authentication {

namespace {

constexpr std::array<std::uint8_t, 8> kMagic{'S', 'T', 'R', 'O', 'B', 'E', 'S', '1'};
constexpr std::size_t kFingerprintAt = kMagic.size();
constexpr std::size_t kSenderAt = kFingerprintAt + 4;
constexpr std::size_t kSequenceAt = kSenderAt + 8;
constexpr std::size_t kPacketMac_bytes = kPacketSeal_bytes - kSealHeader_bytes;
static_assert(kSequenceAt + 8 == kSealHeader_bytes);
static_assert(kPacketMac_bytes >= crypto_generichash_blake2b_BYTES_MIN);

using PacketMac = std::array<std::uint8_t, kPacketMac_bytes>;

PacketMac packet_mac_of(const Key& key, std::string_view channel, Bytes message, Bytes number) {
  // Of a purpose of its own, so that no proof made for another use of the key ever fits here.
  constexpr std::array<std::uint8_t, crypto_generichash_blake2b_PERSONALBYTES> kPurpose{
      's', 't', 'r', 'o', 'b', 'e', '.', 'p', 'a', 'c', 'k', 'e', 't', '.', '.', '1'};
  std::array<std::uint8_t, 8> channel_size{};
  put_big_endian(channel_size, channel.size());
  crypto_generichash_blake2b_state state;
  crypto_generichash_blake2b_init_salt_personal(&state, key.bytes().data(), Key::kBytes, kPacketMac_bytes,
                                                nullptr, kPurpose.data());
  crypto_generichash_blake2b_update(&state, number.data(), number.size());
  crypto_generichash_blake2b_update(&state, channel_size.data() + 6, 2);
  crypto_generichash_blake2b_update(&state, reinterpret_cast<const std::uint8_t*>(channel.data()),
                                    channel.size());
  crypto_generichash_blake2b_update(&state, message.data(), message.size());
  PacketMac mac{};
  crypto_generichash_blake2b_final(&state, mac.data(), mac.size());
  sodium_memzero(&state, sizeof state);
  return mac;
}

bool has_seal(Bytes packet) {
  return packet.size() >= kPacketSeal_bytes &&
         std::ranges::equal(packet.last(kPacketSeal_bytes).first(kMagic.size()), kMagic);
}

std::uint32_t fingerprint_of(const Key& key) {
  const std::string digits = key.fingerprint();
  std::uint32_t value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  return value;
}

}  // namespace

PacketSeal::PacketSeal(const Key& key) : key_(key), fingerprint_(fingerprint_of(key)) {}

std::vector<std::uint8_t> PacketSeal::seal(std::string_view channel, Bytes message,
                                           const PacketNumber& number) const {
  std::vector<std::uint8_t> packet(message.size() + kPacketSeal_bytes);
  std::copy(message.begin(), message.end(), packet.begin());
  const std::span<std::uint8_t> header = std::span(packet).subspan(message.size(), kSealHeader_bytes);
  std::copy(kMagic.begin(), kMagic.end(), header.begin());
  put_big_endian(header.subspan(kFingerprintAt, 4), fingerprint_);
  put_big_endian(header.subspan(kSenderAt, 8), static_cast<std::uint64_t>(number.sender));
  put_big_endian(header.subspan(kSequenceAt, 8), static_cast<std::uint64_t>(number.sequence));
  const PacketMac mac = packet_mac_of(key_, channel, message, header.subspan(kSenderAt));
  std::copy(mac.begin(), mac.end(), packet.end() - kPacketMac_bytes);
  return packet;
}

tl::expected<PacketSeal::Opened, Unverified> PacketSeal::open(std::string_view channel, Bytes packet) const {
  if (!has_seal(packet)) return tl::unexpected(Unverified::unsealed);
  const Bytes message = packet.first(packet.size() - kPacketSeal_bytes);
  const Bytes header = packet.last(kPacketSeal_bytes).first(kSealHeader_bytes);
  if (big_endian(header.subspan(kFingerprintAt, 4)) != fingerprint_)
    return tl::unexpected(Unverified::other_key);
  const PacketMac mac = packet_mac_of(key_, channel, message, header.subspan(kSenderAt));
  if (sodium_memcmp(mac.data(), packet.last(kPacketMac_bytes).data(), kPacketMac_bytes) != 0)
    return tl::unexpected(Unverified::altered);
  return Opened{message,
                {static_cast<std::int64_t>(big_endian(header.subspan(kSenderAt, 8))),
                 static_cast<std::int64_t>(big_endian(header.subspan(kSequenceAt, 8)))}};
}

Bytes message_of(Bytes packet) {
  return has_seal(packet) ? packet.first(packet.size() - kPacketSeal_bytes) : packet;
}

}  // namespace strobe::authentication
