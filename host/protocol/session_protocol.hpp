// The protocol that a session was fired for: its file as the session keeps it, and what the runs tell of it.
// Reads files; thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "common/result.hpp"
#include "host/protocol/protocol.hpp"

namespace strobe::protocol {

/// In the session's folder.
inline constexpr const char* kProtocolFile = "protocol.toml";

struct SessionProtocol {
  Protocol protocol;
  std::string text;        ///< of its file
  std::uint64_t seed = 0;  ///< of the drawn order
};

/// Returns nullopt if the session was fired for none. Fails with the name of a file that cannot be read.
Result<std::optional<SessionProtocol>> protocol_of_session(const std::filesystem::path& folder);

}  // namespace strobe::protocol
