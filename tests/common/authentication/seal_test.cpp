#include "common/authentication/seal.hpp"

#include <algorithm>
#include <random>
#include <string>
#include <strobe_msgs/sealed_command_t.hpp>
#include <vector>

#include "tests/support/string_from.hpp"

using namespace strobe::authentication;
using strobe_msgs::sealed_command_t;
using Bytes = std::vector<std::uint8_t>;

namespace {

const Key kKey = Key::from_text("000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f").value();
const Bytes kBody{1, 2, 3, 4, 5, 6, 7};

}  // namespace

TEST_GROUP(Seal) {
  Bytes sealed = seal(kKey, "bench", kBody).value();

  /// "opened", or why not.
  static std::string answer(const Bytes& bytes, const Key& key = kKey, const char* rig = "bench") {
    const auto body = unseal(key, rig, bytes);
    if (!body) return name(body.error());
    return std::ranges::equal(*body, kBody) ? "opened" : "another body";
  }
};

TEST(Seal, IsOpenedByTheSameKeyForTheSameRig) { CHECK_EQUAL("opened", answer(sealed)); }

TEST(Seal, IsWhatLcmsOwnDecoderReads) {
  sealed_command_t message{};
  LONGS_EQUAL(sealed.size(), message.decode(sealed.data(), 0, static_cast<int>(sealed.size())));
  LONGS_EQUAL(sealed_command_t::SCHEMA_VERSION, message.schema_version);
  STRNCMP_EQUAL("bench", reinterpret_cast<const char*>(message.rig), sizeof message.rig);
  CHECK_EQUAL(kBody, message.body);
}

TEST(Seal, IsTheKeyedHashThatItsHeaderNames) {
  // By another implementation: Python's hashlib.blake2b(bytes, key=bytes(range(32)), digest_size=32,
  // person=b"strobe.command.1"), which is held against this message's own bytes once and for all.
  std::string digits;
  for (std::size_t i = sealed.size() - 32; i < sealed.size(); ++i) {
    constexpr const char* kDigits = "0123456789abcdef";
    digits += kDigits[sealed[i] >> 4];
    digits += kDigits[sealed[i] & 15];
  }
  CHECK_EQUAL("e881f5edca6416f5fde2329acaf83eeafb047d1e3f069ccf19c8b6fbd7807fb1", digits);
}

TEST(Seal, IsNotOpenedByAnotherKey) { CHECK_EQUAL("forged", answer(sealed, Key::random())); }

TEST(Seal, IsNotOpenedForAnotherRig) {
  CHECK_EQUAL("for another rig", answer(sealed, kKey, "bench2"));
  CHECK_EQUAL("for another rig", answer(sealed, kKey, "benc"));
  const std::string longest(24, 'r');
  const Bytes other = seal(kKey, longest, kBody).value();
  CHECK_EQUAL("opened", answer(other, kKey, longest.c_str()));
  CHECK_EQUAL("for another rig", answer(other, kKey, std::string(23, 'r').c_str()));
}

TEST(Seal, IsBrokenByEveryChangeOfOneBit) {
  for (std::size_t bit = 0; bit < 8 * sealed.size(); ++bit) {
    Bytes altered = sealed;
    altered[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    const std::string why = answer(altered);
    // Fingerprint, version and size are looked at before the proof.
    const bool shape = bit / 8 < 12 || (bit / 8 >= 36 && bit / 8 < 40);
    CHECK_EQUAL(shape ? "malformed" : "forged", why);
  }
}

TEST(Seal, IsBrokenByEveryCutAndEveryAddition) {
  for (std::size_t size = 0; size < sealed.size(); ++size)
    CHECK_EQUAL("malformed",
                answer(Bytes(sealed.begin(), sealed.begin() + static_cast<std::ptrdiff_t>(size))));
  sealed.push_back(0);
  CHECK_EQUAL("malformed", answer(sealed));
}

TEST(Seal, HoldsABodyOfAnyAllowedSize) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, kMaxBody_bytes}) {
    const Bytes body(size, 7);
    const Bytes bytes = seal(kKey, "bench", body).value();
    LONGS_EQUAL(kSealed_bytes + size, bytes.size());
    const auto opened = unseal(kKey, "bench", bytes);
    CHECK_TRUE(opened.has_value());
    CHECK_TRUE(std::ranges::equal(*opened, body));
  }
}

TEST(Seal, HoldsNothingLarger) {
  const Bytes body(kMaxBody_bytes + 1, 7);
  STRCMP_CONTAINS("too large", seal(kKey, "bench", body).error().message.c_str());
  CHECK_EQUAL("oversized", answer(Bytes(kMaxSealed_bytes + 1, 7)));
}

TEST(Seal, LooksAtNothingBeyondTheBytes) {
  const unsigned seed = std::random_device{}();
  std::mt19937 random(seed);
  for (int trial = 0; trial < 20'000; ++trial) {
    Bytes bytes = sealed;
    bytes.resize(random() % (2 * sealed.size()));
    for (std::size_t k = random() % 4; k > 0 && !bytes.empty(); --k)
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (bytes != sealed) CHECK_TEXT(!unseal(kKey, "bench", bytes), std::to_string(seed).c_str());
  }
}
