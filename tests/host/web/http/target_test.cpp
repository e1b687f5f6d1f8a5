#include "host/web/http/target.hpp"

#include "tests/support/string_from.hpp"

using strobe::web::is_plain_text;
using strobe::web::parse_target;

namespace {

bool refused(std::string_view text) { return !parse_target(text).has_value(); }

}  // namespace

TEST_GROUP(WebTarget){};

TEST(WebTarget, IsDecodedPartByPart) {
  const auto target = parse_target("/api/a%20b/%C3%A9?limit=10&where=a%3Db%26c&empty=&bare&x=a+b");
  CHECK(target.has_value());
  CHECK_EQUAL("/api/a b/é", target->path);
  CHECK_EQUAL("10", target->query.at("limit"));
  CHECK_EQUAL("a=b&c", target->query.at("where"));
  CHECK_EQUAL("", target->query.at("empty"));
  CHECK_EQUAL("", target->query.at("bare"));
  CHECK_EQUAL("a b", target->query.at("x"));
  CHECK_EQUAL("/a+b", parse_target("/a+b")->path);
}

TEST(WebTarget, OfANameThatComesTwiceTheFirstCounts) {
  CHECK_EQUAL("1", parse_target("/?a=1&a=2")->query.at("a"));
}

TEST(WebTarget, IsRefusedIfItIsNoPath) {
  CHECK(refused(""));
  CHECK(refused("http://127.0.0.1/"));
  CHECK(refused("*"));
  CHECK(refused("api"));
}

TEST(WebTarget, IsRefusedWithBrokenEscapesAndControlCharacters) {
  for (const char* text : {"/%", "/%2", "/%zz", "/%00", "/%0a", "/%1b[2J", "/%7f", "/?a=%0d", "/%c2%9b"})
    CHECK_TEXT(refused(text), text);
}

TEST(WebTarget, IsRefusedWhereItIsNotUtf8) {
  for (const char* text :
       {"/%ff", "/%c0%af", "/%e0%80%af", "/%ed%a0%80", "/%f4%90%80%80", "/%e2%82", "/?%80=1"})
    CHECK_TEXT(refused(text), text);
  CHECK(is_plain_text("ü€😀"));
}
