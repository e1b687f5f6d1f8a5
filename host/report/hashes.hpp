// SHA-256 and Base64 by libsodium. sha256_of_file() reads a file, the rest is pure. Thread-safe; they
// allocate.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe::report {

/// 64 hexadecimal digits.
std::string sha256_hex(std::string_view bytes);
/// Of any size; read piece by piece. Fails with the file's name and the system's reason.
Result<std::string> sha256_of_file(const std::filesystem::path& file);

std::string base64(std::span<const std::uint8_t> bytes);
/// As Content-Security-Policy names a text that it allows: "sha256-…".
std::string policy_hash(std::string_view text);

}  // namespace strobe::report
