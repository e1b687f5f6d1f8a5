#include <sodium.h>

// Without it a debug build ends where a person's file has [[ >]]: the parser asserts what it reports next.
#ifndef TOML_ASSERT
#define TOML_ASSERT(expr) static_assert(true)
#endif
#include <toml++/toml.h>

#include <array>
#include <sstream>

#include "common/config/toml_bounds.hpp"
#include "host/commission/record/record.hpp"

namespace strobe::commission {
namespace {

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash{};
  crypto_hash_sha256(hash.data(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  std::array<char, 2 * crypto_hash_sha256_BYTES + 1> text{};
  sodium_bin2hex(text.data(), text.size(), hash.data(), hash.size());
  return text.data();
}

}  // namespace

std::string tables_hash(const host::RigFile& rig, const std::vector<std::string>& tables) try {
  if (config::toml_bounds_problem(rig.text)) return {};
  const toml::table root = toml::parse(rig.text);
  std::ostringstream out;
  for (const std::string& name : tables) {
    out << '[' << name << "]\n";
    if (const toml::table* table = root[name].as_table()) out << toml::json_formatter(*table) << '\n';
    if (name == "camera") out << rig.calibration_text;
  }
  return sha256(out.str());
} catch (const toml::parse_error&) {
  return {};
}

}  // namespace strobe::commission
