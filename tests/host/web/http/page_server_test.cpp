// The server over real sockets.
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <fmt/format.h>
#include <mutex>
#include <set>
#include <vector>

#include "host/web/http/page_server.hpp"
#include "tests/host/web/http/raw_client.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::web;
using strobe::testing::get;
using strobe::testing::post;
using strobe::testing::RawClient;
using namespace std::chrono_literals;

namespace {

/// Slow work that goes on until it is let go.
class Gated {
 public:
  Response work() {
    std::unique_lock lock(mutex_);
    ++begun_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return open_; });
    return error_response(200, "done");
  }
  void wait_for_begin() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return begun_ > 0; });
  }
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int begun_ = 0;
  bool open_ = false;
};

}  // namespace

TEST_GROUP(WebServer) {
  EventHub hub{1000};
  Router router;
  Gated gated;
  std::atomic<int> stops{0};
  std::unique_ptr<PageServer> server;

  void setup() override {
    router.get("/api/v1/hello", Work::quick,
               [](const Request& request) { return error_response(200, request.from); });
    router.get("/api/v1/large", Work::quick,
               [](const Request&) { return json_text_response(std::string(8 << 20, 'x')); });
    router.get("/api/v1/slow", Work::slow, [this](const Request&) { return gated.work(); });
    router.post("/api/v1/ask", Work::waits, [this](const Request& request) {
      ++stops;
      return error_response(202, request.from);
    });
    router.post("/api/v1/stop", Work::quick, [this](const Request& request) {
      ++stops;
      return error_response(200, request.body);
    });
  }
  void teardown() override { gated.open(); }

  void serve(Limits limits = {}) {
    auto opened = PageServer::open({{"127.0.0.1", 0}, limits}, router, hub);
    CHECK_TEXT(opened.has_value(), opened ? "" : opened.error().message.c_str());
    server = std::move(*opened);
  }
  RawClient client(int receive_buffer_bytes = 0) { return RawClient(server->port(), receive_buffer_bytes); }
  std::string asked(const std::string& bytes) {
    RawClient viewer = client();
    viewer.send(bytes);
    return viewer.read_answer();
  }
  std::string first_line(const std::string& bytes) {
    const std::string answer = asked(bytes);
    return answer.substr(0, answer.find('\r'));
  }
  RawClient watching(std::string_view fields = "") {
    RawClient viewer = client();
    viewer.send(get("/api/v1/events", fields));
    STRCMP_CONTAINS("text/event-stream", viewer.read_until("retry: 1000\n\n").c_str());
    return viewer;
  }
};

TEST(WebServer, GivesThePageItsFilesAndTheInterfaceSafely) {
  serve();
  const std::string page = asked(get("/"));
  for (const char* part :
       {"HTTP/1.1 200 OK", "text/html; charset=utf-8", "default-src 'self'", "nosniff", "<!doctype html>"})
    STRCMP_CONTAINS(part, page.c_str());
  const std::string answer = asked(get("/api/v1/hello"));
  STRCMP_CONTAINS("no-store", answer.c_str());
  STRCMP_CONTAINS("{\"error\":\"127.0.0.1\"}", answer.c_str());
  CHECK_EQUAL("HTTP/1.1 404 Not Found", first_line(get("/nothing.js")));
  CHECK_EQUAL("HTTP/1.1 404 Not Found", first_line(get("/../../etc/passwd")));
  CHECK_EQUAL("HTTP/1.1 404 Not Found", first_line(get("/%2e%2e/%2e%2e/etc/passwd")));
}

TEST(WebServer, SendsAFileThatAViewerHasNoSecondTime) {
  serve();
  const std::string page = asked(get("/"));
  const std::size_t tag = page.find("ETag: ");
  const std::string etag = page.substr(tag + 6, page.find('\r', tag) - tag - 6);
  const std::string again = asked(get("/", "If-None-Match: " + etag + "\r\n"));
  STRCMP_CONTAINS("HTTP/1.1 304", again.c_str());
  CHECK(again.find("<!doctype") == std::string::npos);
}

TEST(WebServer, AnswersOneRequestAfterTheOtherOnAConnection) {
  serve();
  RawClient viewer = client();
  viewer.send(get("/api/v1/hello") + post("/api/v1/stop", "{\"a\":1}") + get("/api/v1/none"));  // at once
  STRCMP_CONTAINS("127.0.0.1", viewer.read_answer().c_str());
  STRCMP_CONTAINS("{\\\"a\\\":1}", viewer.read_answer().c_str());
  STRCMP_CONTAINS("404", viewer.read_answer().c_str());
}

TEST(WebServer, TakesARequestThatComesByteByByte) {
  serve();
  RawClient viewer = client();
  for (const char c : post("/api/v1/stop", "{}")) viewer.send({&c, 1});
  STRCMP_CONTAINS("HTTP/1.1 200", viewer.read_answer().c_str());
  LONGS_EQUAL(1, stops);
}

TEST(WebServer, TellsHeadWhatGetWouldBringWithoutBringingIt) {
  serve();
  RawClient viewer = client();
  viewer.send("HEAD /api/v1/large HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  const std::string all = viewer.read_all();
  STRCMP_CONTAINS("Content-Length: 8388608", all.c_str());
  CHECK(all.ends_with("\r\n\r\n"));
}

TEST(WebServer, WaitsForTheBodyOfWhoAsksWhetherToSendIt) {
  serve();
  RawClient viewer = client();
  viewer.send(
      "POST /api/v1/stop HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: "
      "2\r\n"
      "Expect: 100-continue\r\n\r\n");
  CHECK_EQUAL("HTTP/1.1 100 Continue\r\n\r\n", viewer.read_until("\r\n\r\n"));
  viewer.send("{}");
  STRCMP_CONTAINS("HTTP/1.1 200", viewer.read_answer().c_str());
}

TEST(WebServer, RefusesWhatIsMalformedOrTooLargeAndNothingIsDone) {
  serve();
  for (const char* bytes :
       {"\r\n\r\n\r\n", "hello\r\n\r\n", "GET / HTTP/1.1\r\nHost localhost\r\n\r\n",
        "GET  / HTTP/1.1\r\n\r\n", "GET http://localhost/ HTTP/1.1\r\nHost: localhost\r\n\r\n",
        "GET /%zz HTTP/1.1\r\nHost: localhost\r\n\r\n", "GET / HTTP/1.1\r\n\r\n",
        "GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n",
        "POST /api/v1/stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n",
        "POST /api/v1/stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n{}",
        "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n"})
    CHECK_EQUAL("HTTP/1.1 400 Bad Request", first_line(bytes));
  CHECK_EQUAL("HTTP/1.1 431 Request Header Fields Too Large",
              first_line(get("/", "A: " + std::string(17000, 'x') + "\r\n")));
  CHECK_EQUAL("HTTP/1.1 413 Payload Too Large", first_line(post("/api/v1/stop", std::string(300000, ' '))));
  CHECK_EQUAL("HTTP/1.1 413 Payload Too Large",
              first_line("POST /api/v1/stop HTTP/1.1\r\nHost: localhost\r\nContent-Type: "
                         "application/json\r\nContent-Length: "
                         "9999999999\r\n\r\n"));
  CHECK_EQUAL("HTTP/1.1 411 Length Required",
              first_line("POST /api/v1/stop HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                         "Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n"));
  LONGS_EQUAL(0, stops);
}

TEST(WebServer, RefusesOtherSitesAndMethodsAndNothingIsDone) {
  serve();
  CHECK_EQUAL("HTTP/1.1 403 Forbidden",
              first_line(post("/api/v1/stop", "{}", "Origin: http://evil.example\r\n")));
  CHECK_EQUAL("HTTP/1.1 403 Forbidden", first_line(get("/api/v1/events", "Origin: http://evil.example\r\n")));
  CHECK_EQUAL("HTTP/1.1 403 Forbidden", first_line(get("/", "", "evil.example")));
  CHECK_EQUAL("HTTP/1.1 405 Method Not Allowed", first_line("DELETE / HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  CHECK_EQUAL("HTTP/1.1 405 Method Not Allowed", first_line(post("/", "{}")));
  CHECK_EQUAL("HTTP/1.1 405 Method Not Allowed", first_line(get("/api/v1/stop")));
  CHECK_EQUAL("HTTP/1.1 415 Unsupported Media Type",
              first_line("POST /api/v1/stop HTTP/1.1\r\nHost: localhost\r\nContent-Type: "
                         "text/plain\r\nContent-Length: 2\r\n\r\n{}"));
  LONGS_EQUAL(0, stops);
}

TEST(WebServer, OnAnyAddressAsksForTheSecret) {
  auto opened = PageServer::open({{"0.0.0.0", 0}}, router, hub);
  CHECK(opened.has_value());
  server = std::move(*opened);
  const std::string secret = server->secret();
  LONGS_EQUAL(43, secret.size());
  CHECK(server->url_with_secret().ends_with("/?secret=" + secret));
  CHECK_EQUAL("HTTP/1.1 401 Unauthorized", first_line(get("/")));
  CHECK_EQUAL("HTTP/1.1 401 Unauthorized", first_line(get("/api/v1/events")));
  CHECK_EQUAL("HTTP/1.1 401 Unauthorized", first_line(get("/?secret=wrong")));
  CHECK_EQUAL("HTTP/1.1 401 Unauthorized",
              first_line(post("/api/v1/stop", "{}", "Authorization: Bearer wrong\r\n")));
  LONGS_EQUAL(0, stops);
  CHECK_EQUAL("HTTP/1.1 200 OK",
              first_line(post("/api/v1/stop", "{}", "Authorization: Bearer " + secret + "\r\n")));
  const std::string welcome = asked(get("/?secret=" + secret));
  STRCMP_CONTAINS("HTTP/1.1 303 See Other\r\nLocation: /\r\n", welcome.c_str());
  const std::size_t at = welcome.find("Set-Cookie: ");
  const std::string cookie = welcome.substr(at + 12, welcome.find(';', at) - at - 12);
  CHECK_EQUAL("HTTP/1.1 200 OK", first_line(get("/", "Cookie: " + cookie + "\r\n")));
}

TEST(WebServer, NamesATakenPort) {
  serve();
  const auto second = PageServer::open({{"127.0.0.1", server->port()}}, router, hub);
  CHECK(!second);
  CHECK_EQUAL(fmt::format("127.0.0.1:{}: Address already in use", server->port()), second.error().message);
}

TEST(WebServer, TellsEveryViewerWhatHappens) {
  serve();
  RawClient first = watching(), second = watching();
  STRCMP_CONTAINS("event: reset", first.read_until("\n\n").c_str());
  STRCMP_CONTAINS("event: reset", second.read_until("\n\n").c_str());
  hub.publish("shot", "{\"name\":\"7\"}");
  for (RawClient* viewer : {&first, &second})
    CHECK_EQUAL("id: 1000\nevent: shot\ndata: {\"name\":\"7\"}\n\n", viewer->read_until("\n\n"));
}

TEST(WebServer, GoesOnWhereAViewerWas) {
  serve();
  for (int i = 0; i < 3; ++i) hub.publish("status", std::to_string(i));
  RawClient back = watching("Last-Event-ID: 1000\r\n");
  CHECK_EQUAL("id: 1001\nevent: status\ndata: 1\n\n", back.read_until("\n\n"));
  CHECK_EQUAL("id: 1002\nevent: status\ndata: 2\n\n", back.read_until("\n\n"));
  RawClient script = client();
  script.send(get("/api/v1/events?after=1001"));
  script.read_until("retry: 1000\n\n");
  CHECK_EQUAL("id: 1002\nevent: status\ndata: 2\n\n", script.read_until("\n\n"));
  RawClient lost = watching("Last-Event-ID: 17\r\n");
  CHECK_EQUAL("id: 1002\nevent: reset\ndata: {}\n\n", lost.read_until("\n\n"));
}

TEST(WebServer, HasNoMoreViewersThanItsLimit) {
  Limits limits;
  limits.viewers = 2;
  serve(limits);
  RawClient first = watching(), second = watching();
  CHECK_EQUAL("HTTP/1.1 503 Service Unavailable", first_line(get("/api/v1/events")));
  first.close();
  // The server notices; how soon is its own business.
  std::string line;
  do line = first_line(get("/api/v1/events"));
  while (line.find("503") != line.npos);
  CHECK_EQUAL("HTTP/1.1 200 OK", line);
}

TEST(WebServer, AViewerWhoDoesNotReadHoldsUpNobodyAndIsDropped) {
  Limits limits;
  limits.patience.write = 300ms;
  limits.viewers = 2;
  serve(limits);
  RawClient slow = client(4096);
  slow.send(get("/api/v1/events"));
  RawClient quick = watching();
  quick.read_until("\n\n");
  const std::string event(100000, 'x');
  for (int i = 0; i < 100; ++i) {
    hub.publish("series", event);  // more than any buffer between takes
    LONGS_EQUAL(event.size(),
                quick.read_until("\n\n").size() - std::string("id: 1000\nevent: series\ndata: \n\n").size());
  }
  // His place is another's.
  std::string line;
  do line = first_line(get("/api/v1/events"));
  while (line.find("503") != line.npos);
  CHECK_EQUAL("HTTP/1.1 200 OK", line);
}

TEST(WebServer, AViewerWhoFallsBehindIsToldToFetchEverythingAnew) {
  serve();
  RawClient slow = client(4096);
  slow.send(get("/api/v1/events"));
  RawClient quick = watching();
  quick.read_until("\n\n");
  const std::string event(EventHub::kMaxKept_bytes / 8, 'x');
  for (int i = 0; i < 40; ++i) {
    hub.publish("series", event);
    quick.read_until("\n\n");
  }
  std::string text;
  do text = slow.read_until("\n\n");
  while (text.find("event: reset") == text.npos || text.find("id: 999\n") != text.npos);
  STRCMP_CONTAINS("data: {}\n\n", text.c_str());
}

TEST(WebServer, ClosesAConnectionOnWhichNoRequestBecomesWhole) {
  Limits limits;
  limits.patience.first_request = 200ms;
  serve(limits);
  RawClient silent = client(), dripping = client();
  dripping.send("GET / HTTP/1.1\r\nHost: loc");
  CHECK_EQUAL("", silent.read_all());
  CHECK_EQUAL("", dripping.read_all());
}

TEST(WebServer, ClosesAnIdleConnection) {
  Limits limits;
  limits.patience.idle = 200ms;
  serve(limits);
  RawClient viewer = client();
  viewer.send(get("/api/v1/hello"));
  viewer.read_answer();
  CHECK_EQUAL("", viewer.read_all());
}

TEST(WebServer, UnderHundredsOfConnectionsAnswersThoseWhoAsk) {
  serve();
  RawClient quick = watching();
  quick.read_until("\n\n");
  std::vector<RawClient> strangers;
  for (int i = 0; i < 600; ++i) {
    strangers.push_back(client());
    if (i % 3 == 0) strangers.back().send("GET / HTTP/1.1\r\n");
    if (i % 100 == 0) CHECK_EQUAL("HTTP/1.1 200 OK", first_line(get("/api/v1/hello")));
  }
  hub.publish("shot", "{}");
  CHECK_EQUAL("id: 1000\nevent: shot\ndata: {}\n\n", quick.read_until("\n\n"));
}

TEST(WebServer, WhereAllConnectionsAreInUseSaysSo) {
  Limits limits;
  limits.connections = 3;
  serve(limits);
  std::vector<RawClient> users;
  for (int i = 0; i < 3; ++i) {
    users.push_back(client());
    users.back().send(get("/api/v1/hello"));
    users.back().read_answer();
  }
  STRCMP_CONTAINS("HTTP/1.1 503 Service Unavailable", client().read_all().c_str());
  users[1].close();
  std::string line;
  do line = first_line(get("/api/v1/hello"));
  while (line.find("503") != line.npos);
  CHECK_EQUAL("HTTP/1.1 200 OK", line);
}

TEST(WebServer, SlowWorkHoldsUpNothingElseAndItsQueueEnds) {
  Limits limits;
  limits.slow_requests = 2;
  serve(limits);
  std::vector<RawClient> waiting;
  waiting.push_back(client());
  waiting.back().send(get("/api/v1/slow"));
  gated.wait_for_begin();
  for (int i = 0; i < 4; ++i) {
    waiting.push_back(client());
    waiting.back().send(get("/api/v1/slow"));
  }
  const auto refused = [&waiting] {
    return std::ranges::count_if(waiting, [](const RawClient& viewer) { return viewer.has_something(); });
  };
  while (refused() < 2) CHECK_EQUAL("HTTP/1.1 200 OK", first_line(get("/api/v1/hello")));
  CHECK_EQUAL("HTTP/1.1 202 Accepted", first_line(post("/api/v1/ask", "{}")));
  gated.open();
  std::multiset<std::string> answers;
  for (RawClient& viewer : waiting) answers.insert(viewer.read_answer().substr(9, 3));
  CHECK((answers == std::multiset<std::string>{"200", "200", "200", "503", "503"}));
}

TEST(WebServer, AtItsEndTellsTheViewersAndCloses) {
  serve();
  RawClient viewer = watching();
  viewer.read_until("\n\n");
  CHECK(server->end());
  CHECK_EQUAL("id: 1000\nevent: end\ndata: {}\n\n", viewer.read_all());
}

TEST(WebServer, EndsAlthoughAViewerDoesNotRead) {
  serve();
  RawClient slow = client(4096);
  slow.send(get("/api/v1/large"));
  RawClient viewer = client(4096);
  viewer.send(get("/api/v1/events"));
  for (int i = 0; i < 20; ++i) hub.publish("series", std::string(100000, 'x'));
  CHECK(server->end());
}

using strobe::web::ListenAddress;
using strobe::web::parse_listen_address;

TEST_GROUP(WebListenAddress){static void takes(std::string_view text, const std::string& address,
                                               int port){const auto read = parse_listen_address(text);
CHECK_TEXT(read.has_value(), std::string(text).c_str());
CHECK_EQUAL(address, read->address);
LONGS_EQUAL(port, read->port);
}
}
;

TEST(WebListenAddress, HasADefaultForWhatIsLeftOut) {
  takes("", "127.0.0.1", 8650);
  takes("9000", "127.0.0.1", 9000);
  takes("0", "127.0.0.1", 0);
  takes("192.168.1.7", "192.168.1.7", 8650);
  takes("localhost", "127.0.0.1", 8650);
  takes("[::1]", "::1", 8650);
}

TEST(WebListenAddress, IsAnAddressInFiguresAndAPort) {
  takes("0.0.0.0:80", "0.0.0.0", 80);
  takes("localhost:65535", "127.0.0.1", 65535);
  takes("[fe80::1]:0", "fe80::1", 0);
}

TEST(WebListenAddress, IsRefusedOtherwiseWithWhatWasGiven) {
  for (const char* text :
       {"lab-pc", "lab-pc:80", "65536", "127.0.0.1:65536", "127.0.0.1:", ":8650", "127.0.0.1:+1", "::1",
        "[::1", "[::1]8650", "[1.2.3.4]:1", "1.2.3:4", "-1", " ", "127.0.0.1:1 "}) {
    const auto read = parse_listen_address(text);
    CHECK_TEXT(!read, text);
    STRCMP_CONTAINS(text, read.error().message.c_str());
  }
}
