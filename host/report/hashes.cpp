#include "host/report/hashes.hpp"

#include <sodium.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

namespace strobe::report {

namespace {

using Hash = std::array<unsigned char, crypto_hash_sha256_BYTES>;

class Hasher {
 public:
  Hasher() { crypto_hash_sha256_init(&state_); }
  void add(const char* bytes, std::size_t count) {
    crypto_hash_sha256_update(&state_, reinterpret_cast<const unsigned char*>(bytes), count);
  }
  Hash end() {
    Hash hash{};
    crypto_hash_sha256_final(&state_, hash.data());
    return hash;
  }

 private:
  crypto_hash_sha256_state state_{};
};

std::string hex(const Hash& hash) {
  std::array<char, 2 * crypto_hash_sha256_BYTES + 1> text{};
  sodium_bin2hex(text.data(), text.size(), hash.data(), hash.size());
  return text.data();
}

Hash sha256(std::string_view bytes) {
  Hasher hasher;
  hasher.add(bytes.data(), bytes.size());
  return hasher.end();
}

}  // namespace

std::string sha256_hex(std::string_view bytes) { return hex(sha256(bytes)); }

Result<std::string> sha256_of_file(const std::filesystem::path& file) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  Hasher hasher;
  std::vector<char> piece(std::size_t{1} << 18);
  while (in) {
    in.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    hasher.add(piece.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (!in.eof()) return fail(file.string() + ": cannot be read: " + std::strerror(errno));
  return hex(hasher.end());
}

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr int kVariant = sodium_base64_VARIANT_ORIGINAL;
  std::string text(sodium_base64_encoded_len(bytes.size(), kVariant), '\0');
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), kVariant);
  text.pop_back();  // its end, a NUL
  return text;
}

std::string policy_hash(std::string_view text) { return "sha256-" + base64(sha256(text)); }

}  // namespace strobe::report
