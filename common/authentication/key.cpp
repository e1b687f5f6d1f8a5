#include "common/authentication/key.hpp"

#include <sodium.h>

#include <stdexcept>

namespace strobe::authentication {

namespace {

void start_sodium() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be started");
}

std::string hexadecimal(std::span<const std::uint8_t> bytes) {
  std::string text(2 * bytes.size() + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  text.pop_back();
  return text;
}

}  // namespace

Key Key::random() {
  start_sodium();
  Key key;
  randombytes_buf(key.bytes_.data(), key.bytes_.size());
  return key;
}

Result<Key> Key::from_text(std::string_view text) {
  start_sodium();
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' '))
    text.remove_suffix(1);
  Key key;
  std::size_t size = 0;
  const char* end = nullptr;
  if (text.size() != 2 * kBytes ||
      sodium_hex2bin(key.bytes_.data(), kBytes, text.data(), text.size(), nullptr, &size, &end) != 0) {
    return fail("not a key of 64 hexadecimal digits");
  }
  if (size != kBytes || end != text.data() + text.size()) return fail("not a key of 64 hexadecimal digits");
  return key;
}

Key::~Key() { sodium_memzero(bytes_.data(), bytes_.size()); }

std::string Key::text() const { return hexadecimal(bytes_); }

std::string Key::fingerprint() const {
  std::array<std::uint8_t, crypto_generichash_BYTES> hash{};
  crypto_generichash(hash.data(), hash.size(), bytes_.data(), bytes_.size(), nullptr, 0);
  return hexadecimal(std::span(hash).first(4));
}

}  // namespace strobe::authentication
