#include "host/web/http/access.hpp"

#include <set>

#include "tests/support/string_from.hpp"

using namespace strobe::web;

namespace {

constexpr const char* kSecret = "right-secret";

RequestHead got(std::string_view host, std::string_view method = "GET", std::string_view target = "/") {
  RequestHead head;
  head.method = method;
  head.target = target;
  head.hosts = {host};
  return head;
}

RequestHead posted(std::string_view host) {
  RequestHead head = got(host, "POST", "/api/v1/stop");
  head.content_type = "application/json";
  return head;
}

}  // namespace

TEST_GROUP(WebAccess) {
  const Access local{{true, "lab-pc", "", 8650}};
  const Access open{{false, "lab-pc", kSecret, 8650}};

  static int status(const Access& access, const RequestHead& head) {
    const auto refused = access.check(head);
    return refused ? refused->status : 200;
  }
};

TEST(WebAccess, OnLoopbackTakesItsNamesOnlyWhateverThePort) {
  for (const char* host :
       {"127.0.0.1:8650", "localhost:8650", "LOCALHOST", "localhost:9000", "[::1]:8650", "127.1.2.3"})
    CHECK_EQUAL(200, status(local, got(host)));
  for (const char* host : {"evil.example:8650", "lab-pc:8650", "192.168.1.7:8650", "127.0.0.1.evil.example",
                           "localhost.evil.example", "", ":8650", "[::1", "[]", "127.0.0.1:8650:1",
                           "127.0.0.1:port", "127.0.0.1@evil.example"})
    CHECK_EQUAL(403, status(local, got(host)));
}

TEST(WebAccess, ElsewhereTakesAddressesAndTheMachinesNameAsNoOtherNameCanBeItsOwn) {
  for (const char* host : {"192.168.1.7:8650", "lab-pc:8650", "LAB-PC", "[fe80::1]:8650", "localhost:8650"})
    CHECK_EQUAL(401, status(open, got(host)));  // the Host is right, the secret is missing
  for (const char* host : {"evil.example", "lab-pc.evil.example"}) CHECK_EQUAL(403, status(open, got(host)));
}

TEST(WebAccess, WantsExactlyOneHost) {
  RequestHead head = got("localhost");
  head.hosts = {};
  CHECK_EQUAL(400, status(local, head));
  head.hosts = {"localhost", "localhost"};
  CHECK_EQUAL(400, status(local, head));
}

TEST(WebAccess, RefusesAnyOtherOrigin) {
  RequestHead head = posted("localhost:8650");
  head.origin = "http://localhost:8650";
  CHECK_EQUAL(200, status(local, head));
  for (const char* origin :
       {"http://evil.example", "null", "", "http://localhost:3000", "https://localhost:8650",
        "http://localhost:8650.evil.example", "http://127.0.0.1:8650"}) {
    head.origin = origin;
    CHECK_EQUAL(403, status(local, head));
  }
}

TEST(WebAccess, RefusesWhatABrowserSaysComesFromAnotherSiteUnlessItOpensThePage) {
  RequestHead head = got("localhost:8650", "GET", "/api/v1/live");
  for (const char* site : {"same-origin", "none"}) {
    head.fetch_site = site;
    CHECK_EQUAL(200, status(local, head));
  }
  for (const char* site : {"cross-site", "same-site"}) {
    head.fetch_site = site;
    CHECK_EQUAL(403, status(local, head));
  }
  head.fetch_mode = "navigate";
  head.fetch_dest = "iframe";
  CHECK_EQUAL(403, status(local, head));
  head.fetch_dest = "document";
  CHECK_EQUAL(200, status(local, head));
}

TEST(WebAccess, TakesThreeMethods) {
  CHECK_EQUAL(200, status(local, got("localhost", "HEAD")));
  for (const char* method : {"PUT", "DELETE", "OPTIONS", "CONNECT", "TRACE", "get", ""})
    CHECK_EQUAL(405, status(local, got("localhost", method)));
}

TEST(WebAccess, WantsJsonInAPost) {
  RequestHead head = posted("localhost");
  for (const char* type : {"application/json", "Application/JSON; charset=utf-8"}) {
    head.content_type = type;
    CHECK_EQUAL(200, status(local, head));
  }
  for (const char* type :
       {"text/plain", "application/x-www-form-urlencoded", "multipart/form-data", "application/jsonx", ""}) {
    head.content_type = type;
    CHECK_EQUAL(415, status(local, head));
  }
  head.content_type.reset();
  CHECK_EQUAL(415, status(local, head));
}

TEST(WebAccess, WithASecretLetsInWhoHasIt) {
  RequestHead head = posted("192.168.1.7:8650");
  CHECK_EQUAL(401, status(open, head));
  head.authorization = "Bearer right-secret";
  CHECK_EQUAL(200, status(open, head));
  head.authorization = "bearer  right-secret ";
  CHECK_EQUAL(200, status(open, head));
  head.authorization.reset();
  head.cookie = "a=b; strobe_8650=right-secret; c=d";
  CHECK_EQUAL(200, status(open, head));
}

TEST(WebAccess, WithAWrongSecretLetsNobodyIn) {
  RequestHead head = got("192.168.1.7:8650");
  for (const char* given : {"Bearer wrong", "Bearer ", "Bearer", "right-secret", "Basic right-secret",
                            "Bearer right-secre", "Bearer right-secretx"}) {
    head.authorization = given;
    CHECK_EQUAL(401, status(open, head));
  }
  head.authorization.reset();
  for (const char* cookie : {"strobe_8650=wrong", "strobe_8650=", "strobe_8651=right-secret",
                             "xstrobe_8650=right-secret", ";;=;", "strobe_8650"}) {
    head.cookie = cookie;
    CHECK_EQUAL(401, status(open, head));
  }
}

TEST(WebAccess, GivesACookieForTheAddressWithTheRightSecretAlone) {
  const auto cookie = open.cookie_for(got("192.168.1.7:8650", "GET", "/?secret=right-secret"));
  CHECK(cookie.has_value());
  CHECK_EQUAL("strobe_8650=right-secret; Path=/; HttpOnly; SameSite=Strict", *cookie);
  CHECK(!open.cookie_for(got("192.168.1.7:8650", "GET", "/?secret=wrong")));
  CHECK(!open.cookie_for(got("192.168.1.7:8650", "GET", "/")));
  CHECK(!open.cookie_for(got("192.168.1.7:8650", "GET", "/api/v1/live?secret=right-secret")));
  CHECK(!open.cookie_for(got("192.168.1.7:8650", "POST", "/?secret=right-secret")));
  CHECK(!open.cookie_for(got("evil.example", "GET", "/?secret=right-secret")));
  CHECK(!local.cookie_for(got("localhost", "GET", "/?secret=")));
}

TEST(WebAccess, SecretsAreLongAndDiffer) {
  std::set<std::string> secrets;
  for (int i = 0; i < 20; ++i) secrets.insert(random_secret());
  LONGS_EQUAL(20, secrets.size());
  for (const std::string& secret : secrets) {
    LONGS_EQUAL(43, secret.size());  // 256 bits, six to a character
    CHECK(secret.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_") ==
          secret.npos);
  }
}
