#include "common/authentication/seal.hpp"

#include <sodium.h>

#include <algorithm>
#include <strobe_msgs/sealed_command_t.hpp>

#include "common/authentication/big_endian.hpp"

namespace strobe::authentication {

namespace {

using strobe_msgs::sealed_command_t;

// Where the fields are in the encoded message: LCM packs them in order, big-endian, behind 8 bytes of
// fingerprint.
constexpr std::size_t kVersionAt = 8;
constexpr std::size_t kRigAt = 12;
constexpr std::size_t kRig_bytes = sizeof(sealed_command_t::rig);
constexpr std::size_t kBodySizeAt = kRigAt + kRig_bytes;
constexpr std::size_t kBodyAt = kBodySizeAt + 4;
constexpr std::size_t kMac_bytes = sizeof(sealed_command_t::mac);
static_assert(kBodyAt + kMac_bytes == kSealed_bytes);
static_assert(kMac_bytes == crypto_generichash_blake2b_BYTES);
static_assert(Key::kBytes == crypto_generichash_blake2b_KEYBYTES);

using Mac = std::array<std::uint8_t, kMac_bytes>;

Mac mac_of(const Key& key, std::span<const std::uint8_t> bytes) {
  // Of a purpose of its own, so that no proof made for another use of the key ever fits here.
  constexpr std::array<std::uint8_t, crypto_generichash_blake2b_PERSONALBYTES> kPurpose{
      's', 't', 'r', 'o', 'b', 'e', '.', 'c', 'o', 'm', 'm', 'a', 'n', 'd', '.', '1'};
  Mac mac{};
  crypto_generichash_blake2b_salt_personal(mac.data(), mac.size(), bytes.data(), bytes.size(),
                                           key.bytes().data(), Key::kBytes, nullptr, kPurpose.data());
  return mac;
}

bool shaped(std::span<const std::uint8_t> sealed) {
  return sealed.size() >= kSealed_bytes &&
         big_endian(sealed.first(kVersionAt)) == static_cast<std::uint64_t>(sealed_command_t::getHash()) &&
         big_endian(sealed.subspan(kVersionAt, 4)) == sealed_command_t::SCHEMA_VERSION &&
         big_endian(sealed.subspan(kBodySizeAt, 4)) == sealed.size() - kSealed_bytes;
}

}  // namespace

Result<std::vector<std::uint8_t>> seal(const Key& key, std::string_view rig,
                                       std::span<const std::uint8_t> body) {
  if (body.size() > kMaxBody_bytes) {
    return fail("a command of " + std::to_string(body.size()) + " bytes is too large: at most " +
                std::to_string(kMaxBody_bytes));
  }
  sealed_command_t message{};
  message.schema_version = sealed_command_t::SCHEMA_VERSION;
  std::copy_n(rig.begin(), std::min(rig.size(), kRig_bytes), message.rig);
  message.body_size = static_cast<std::int32_t>(body.size());
  message.body.assign(body.begin(), body.end());
  std::vector<std::uint8_t> sealed(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(sealed.data(), 0, static_cast<int>(sealed.size()));
  const Mac mac = mac_of(key, std::span(sealed).first(sealed.size() - kMac_bytes));
  std::copy(mac.begin(), mac.end(), sealed.end() - kMac_bytes);
  return sealed;
}

tl::expected<std::span<const std::uint8_t>, Rejection> unseal(const Key& key, std::string_view rig,
                                                              std::span<const std::uint8_t> sealed) {
  if (sealed.size() > kMaxSealed_bytes) return tl::unexpected(Rejection::oversized);
  if (!shaped(sealed)) return tl::unexpected(Rejection::malformed);
  const Mac mac = mac_of(key, sealed.first(sealed.size() - kMac_bytes));
  if (sodium_memcmp(mac.data(), sealed.last(kMac_bytes).data(), kMac_bytes) != 0)
    return tl::unexpected(Rejection::forged);
  std::array<std::uint8_t, kRig_bytes> mine{};
  std::copy_n(rig.begin(), std::min(rig.size(), kRig_bytes), mine.begin());
  if (!std::ranges::equal(mine, sealed.subspan(kRigAt, kRig_bytes)))
    return tl::unexpected(Rejection::other_rig);
  return sealed.subspan(kBodyAt, sealed.size() - kSealed_bytes);
}

}  // namespace strobe::authentication
