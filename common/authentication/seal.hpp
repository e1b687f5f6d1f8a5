// Authenticated commands: seals and opens sealed_command_t, whose MAC is a keyed BLAKE2b (RFC 7693) of every
// byte before it. Pure; allocates; thread-safe; not for the real-time path.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/authentication/rejection.hpp"

namespace strobe::authentication {

/// Of the sealed command's body. A datagram holds 65,507 bytes.
inline constexpr std::size_t kMaxBody_bytes = 60'000;
/// Of a sealed command without its body: fingerprint, version, rig, body's size, MAC.
inline constexpr std::size_t kSealed_bytes = 8 + 4 + 24 + 4 + 32;
inline constexpr std::size_t kMaxSealed_bytes = kSealed_bytes + kMaxBody_bytes;

/// The encoded sealed_command_t. rig: a valid name (messages::valid_rig_name). Fails if the body is larger
/// than kMaxBody_bytes.
Result<std::vector<std::uint8_t>> seal(const Key& key, std::string_view rig,
                                       std::span<const std::uint8_t> body);

/// The body, a part of `sealed`. Fails with oversized, malformed, forged or other_rig, checked in this order.
/// Valid: any bytes. Takes a time that depends on the size alone, not on how much of a forged MAC is right.
tl::expected<std::span<const std::uint8_t>, Rejection> unseal(const Key& key, std::string_view rig,
                                                              std::span<const std::uint8_t> sealed);

}  // namespace strobe::authentication
