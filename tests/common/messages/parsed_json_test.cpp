// JSON that others wrote: what nests deeper than any of ours is none.
#include "common/messages/parsed_json.hpp"

#include <string>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::messages;
using nlohmann::ordered_json;

ordered_json parsed(const std::string& text) { return parsed_json<ordered_json>(text); }

std::string nested(int depth) {
  const auto levels = static_cast<std::size_t>(depth);
  return std::string(levels, '[') + std::string(levels, ']');
}

}  // namespace

TEST_GROUP(ParsedJson){};

TEST(ParsedJson, WhatNestsTooDeepIsNone) {
  CHECK_FALSE(parsed(nested(kMaxJsonDepth)).is_discarded());
  CHECK_TRUE(parsed(nested(kMaxJsonDepth + 1)).is_discarded());
  CHECK_TRUE(parsed(nested(4'000'000)).is_discarded());
  CHECK_TRUE(parsed("{\"a\":\"\\\\\",\"b\":" + nested(kMaxJsonDepth) + "}").is_discarded());
}

TEST(ParsedJson, BracketsInTextsDoNotCount) {
  const std::string text = "[\"" + std::string(1000, '[') + "\\\"" + std::string(1000, '{') + "\\\\\"]";
  LONGS_EQUAL(1, json_depth(text));
  CHECK_FALSE(parsed(text).is_discarded());
}

TEST(ParsedJson, SoManyBesideEachOtherAreNotDeep) {
  std::string text = "[[]";
  for (int i = 0; i < 1000; ++i) text += ",[{}]";
  CHECK_FALSE(parsed(text + "]").is_discarded());
  for (const char* none : {"", "[", "]]", "\"", "\"\\", "{\"a\"", "\xff"})
    CHECK_TRUE(parsed(none).is_discarded());
}
