#include "common/authentication/key.hpp"

#include <string>

#include "tests/support/string_from.hpp"

using strobe::authentication::Key;

namespace {

const std::string kText = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f";

}  // namespace

TEST_GROUP(Key){};

TEST(Key, IsReadFromHexadecimalDigits) {
  const auto key = Key::from_text(kText);
  CHECK_TRUE(key.has_value());
  for (std::size_t i = 0; i < Key::kBytes; ++i) LONGS_EQUAL(i, key->bytes()[i]);
  CHECK_EQUAL(kText, key->text());
  CHECK_TRUE(Key::from_text(kText + "\r\n").has_value());
  CHECK_TRUE(Key::from_text("00" + kText.substr(2, 60) + "FF").has_value());
}

TEST(Key, IsNotReadFromAnythingElseAndNoErrorQuotesTheText) {
  for (const std::string& text :
       {std::string(), kText.substr(1), kText + "0", kText + "00", kText + " x", "0x" + kText.substr(2),
        std::string(64, 'g'), "\n" + kText, std::string(64, '\0')}) {
    const auto key = Key::from_text(text);
    CHECK_FALSE(key.has_value());
    CHECK_EQUAL("not a key of 64 hexadecimal digits", key.error().message);
  }
}

TEST(Key, IsDrawnAnewEachTime) { CHECK_TRUE(Key::random().text() != Key::random().text()); }

TEST(Key, HasAFingerprintThatIsNotPartOfIt) {
  const Key key = Key::from_text(kText).value();
  LONGS_EQUAL(8, key.fingerprint().size());
  CHECK_EQUAL(kText.npos, kText.find(key.fingerprint()));
  CHECK_EQUAL(key.fingerprint(), Key::from_text(kText)->fingerprint());
  CHECK_TRUE(key.fingerprint() != Key::random().fingerprint());
}
