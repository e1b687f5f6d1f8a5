// What a browser or a stranger sends to the page's server: any bytes, in any pieces, are a request within limits or are
// refused; none reaches what stops the host unless Host, Origin, method and content type are right; what a path's parts
// become is text that can be shown. Input: a byte for the size of the pieces, then what comes over the connection.
#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <string>

#include "host/web/http/message.hpp"
#include "host/web/http/gate.hpp"
#include "host/web/http/intake.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace strobe::web;
using strobe::fuzz::require;

struct Routes {
  Routes() {
    const auto answer = [](const Request& request) {
      for (const auto& [name, value] : request.parameters) require(!value.empty() && is_plain_text(value));
      return error_response(200, request.path);
    };
    router.get("/api/v1/sessions/{session}/shots/{shot}", Work::slow, answer);
    router.get("/api/v1/live", Work::quick, answer);
    router.post("/api/v1/stop", Work::quick, answer);
  }
  Router router;
};

void check_host(const RequestHead& head) {
  require(head.hosts.size() == 1);
  std::string host(head.hosts[0]);
  std::ranges::transform(host, host.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  host.erase(0, host.find_first_not_of(" \t"));
  require(host.starts_with("127.") || host.starts_with("[::1]") || host.starts_with("localhost"));
}

void check(const Gate& gate, const Intake& intake) {
  const RequestHead head = intake.head();
  auto verdict = gate.on_head(head);
  if (const auto* refused = std::get_if<Response>(&verdict)) {
    require(refused->status >= 400 && refused->status < 500);
    require(answer_of(*refused, false, false).head.starts_with("HTTP/1.1 4"));
    return;
  }
  check_host(head);
  const auto& admitted = std::get<Admitted>(verdict);
  require(is_plain_text(admitted.request.path) && admitted.request.path.starts_with('/'));
  for (const auto& [name, value] : admitted.request.query)
    require(is_plain_text(name) && is_plain_text(value));
  if (head.method == "POST")
    require(admitted.request.path == "/api/v1/stop" && head.content_type.has_value());
  if (admitted.found.handler != nullptr) {
    const Response response = Router::answer(admitted.found, admitted.request);
    const Answer answer = answer_of(response, head.method == "HEAD", intake.keep_alive(), head.etag);
    require(answer.head.find("\r\n\r\n") == answer.head.size() - 4);  // no field of the asker's making
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Routes routes;
  static const Gate gate(Access({true, "lab-pc", "", 8650}), routes.router);
  if (size == 0) return 0;
  const std::size_t piece = std::size_t{data[0]} + 1;
  std::string_view bytes = strobe::fuzz::text_of(data + 1, size - 1);
  Intake intake;
  while (intake.state() != Intake::State::failed) {
    const auto before = intake.state();
    const auto state = intake.step();
    if (state == Intake::State::body && before == Intake::State::head) {
      check(gate, intake);
      continue;
    }
    if (state == Intake::State::complete) {
      require(intake.take_body().size() <= kMaxBody_bytes);
      intake.next();
      continue;
    }
    if (state == Intake::State::failed || bytes.empty()) break;
    intake.add(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
  }
  if (intake.state() == Intake::State::failed)
    require(intake.failure_status() == 400 || intake.failure_status() == 411 ||
            intake.failure_status() == 413 || intake.failure_status() == 431 ||
            intake.failure_status() == 505);
  return 0;
}
