#include <stdexcept>

#include "host/web/http/message.hpp"
#include "host/web/http/router.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::web;

TEST_GROUP(WebRouter) {
  Router router;

  void setup() override {
    router.get("/api/v1/sessions", Work::quick, [](const Request&) { return error_response(200, "list"); });
    router.get("/api/v1/sessions/{session}/shots/{shot}", Work::slow, [](const Request& request) {
      return error_response(200, request.parameters.at("session") + " " + request.parameters.at("shot"));
    });
    router.post("/api/v1/stop", Work::quick,
                [](const Request& request) { return error_response(200, request.body); });
    router.get("/bad", Work::quick,
               [](const Request&) -> Response { throw std::runtime_error("two\nlines"); });
  }
  Response asked(const std::string& method, const std::string& path) {
    Request request;
    request.method = method;
    request.path = path;
    return router.route(request);
  }
  std::string text(const std::string& method, const std::string& path) { return *asked(method, path).body; }
};

TEST(WebRouter, FindsAPathAndWhatItsNamesMatch) {
  CHECK_EQUAL("{\"error\":\"list\"}", text("GET", "/api/v1/sessions"));
  CHECK_EQUAL("{\"error\":\"day 1 3\"}", text("GET", "/api/v1/sessions/day 1/shots/3"));
  CHECK_EQUAL("{\"error\":\"day 1 3\"}", text("HEAD", "/api/v1/sessions/day 1/shots/3"));
}

TEST(WebRouter, AnswersWhatIsNotThereWith404) {
  for (const char* path :
       {"/", "", "/api/v1/session", "/api/v1/sessions/", "/api/v1/sessions/a", "/api/v1/sessions//shots/1",
        "/api/v1/sessions/a/shots/", "/api/v1/sessions/a/shots/1/x", "api/v1/sessions"})
    LONGS_EQUAL(404, asked("GET", path).status);
}

TEST(WebRouter, AnswersAnotherMethodWith405) {
  LONGS_EQUAL(405, asked("GET", "/api/v1/stop").status);
  LONGS_EQUAL(405, asked("HEAD", "/api/v1/stop").status);
  LONGS_EQUAL(405, asked("POST", "/api/v1/sessions").status);
}

TEST(WebRouter, PrefersAWordToANameWhateverCameFirst) {
  Router both;
  const auto answer = [](const char* words) {
    return [words](const Request& request) {
      return json_text_response(words + std::to_string(request.parameters.size()));
    };
  };
  both.get("/shots/{shot}/{boot}", Work::quick, answer("boot"));
  both.get("/shots/{shot}/photograph", Work::quick, answer("photograph"));
  both.post("/shots/{shot}/undo", Work::quick, answer("undo"));
  const auto ask = [&](const char* path) {
    Request request;
    request.method = "GET";
    request.path = path;
    return *both.route(request).body;
  };
  CHECK_EQUAL("photograph1", ask("/shots/3/photograph"));
  CHECK_EQUAL("boot2", ask("/shots/3/1f2e4d"));
  CHECK_EQUAL("boot2", ask("/shots/3/undo"));  // with this method
}

TEST(WebRouter, TellsWhichWorkIsSlow) {
  Request request;
  request.method = "GET";
  request.path = "/api/v1/sessions/a/shots/1";
  CHECK(router.find(request).work == Work::slow);
}

TEST(WebRouter, AnswersAnExceptionWith500AndItsWordsInOneLine) {
  LONGS_EQUAL(500, asked("GET", "/bad").status);
  CHECK_EQUAL("{\"error\":\"two lines\"}", text("GET", "/bad"));
}

TEST(WebRouter, ReplacesBytesThatAreNoUtf8InAnAnswer) {
  CHECK_EQUAL("{\"error\":\"a\xEF\xBF\xBD\"}", *error_response(400, "a\xFF").body);
}

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
