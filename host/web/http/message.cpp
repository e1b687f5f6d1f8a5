#include "host/web/http/message.hpp"

#include <fmt/format.h>
#include <glib.h>

#include <algorithm>
#include <boost/beast/http/status.hpp>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"

namespace strobe::web {
namespace {

namespace http = boost::beast::http;

constexpr std::string_view kPolicy =
    "default-src 'self'; img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors "
    "'self'";
constexpr std::string_view kGuards =
    "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: "
    "same-origin\r\nCross-Origin-Opener-Policy: same-origin\r\n";

std::string more_fields(int status, const Response& response) {
  if (status == 303) return fmt::format("Location: /\r\nSet-Cookie: {}\r\n", response.cookie);
  if (status == 401) return "WWW-Authenticate: Bearer\r\n";
  if (status == 405) return "Allow: GET, HEAD, POST\r\n";
  return status == 503 ? "Retry-After: 1\r\n" : "";
}

std::optional<std::string> decoded(std::string text, bool plus_is_blank) {
  if (plus_is_blank) std::ranges::replace(text, '+', ' ');
  const std::unique_ptr<char, decltype(&g_free)> plain(
      g_uri_unescape_segment(text.data(), text.data() + text.size(), nullptr), g_free);
  return plain && is_plain_text(plain.get()) ? std::optional<std::string>(plain.get()) : std::nullopt;
}

}  // namespace

bool is_plain_text(std::string_view text) {
  if (text.empty()) return true;
  if (!g_utf8_validate(text.data(), static_cast<gssize>(text.size()), nullptr)) return false;
  const char* const end = text.data() + text.size();
  for (const char* at = text.data(); at != end; at = g_utf8_next_char(at))
    if (g_unichar_iscntrl(g_utf8_get_char(at))) return false;
  return true;
}

Result<Target> parse_target(std::string_view text) {
  if (!text.starts_with('/')) return fail("the target must be a path");
  const std::size_t mark = std::min(text.find('?'), text.size());
  const auto path = decoded(std::string(text.substr(0, mark)), false);
  if (!path) return fail("the path is no escaped UTF-8");
  Target target{*path, {}};
  std::string_view rest = text.substr(std::min(mark + 1, text.size()));
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    if (pair.empty()) continue;
    const std::size_t equals = std::min(pair.find('='), pair.size());
    const auto name = decoded(std::string(pair.substr(0, equals)), true);
    const auto value = decoded(std::string(pair.substr(std::min(pair.size(), equals + 1))), true);
    if (!name || !value) return fail("the query is no escaped UTF-8");
    target.query.emplace(*name, *value);
  }
  return target;
}

Response json_text_response(std::string json, int status) {
  return {.status = status, .body = std::make_shared<const std::string>(std::move(json))};
}

Response json_response(const nlohmann::ordered_json& json, int status) {
  return json_text_response(messages::json_text(json), status);
}

Response error_response(int status, std::string_view words) {
  return json_response({{"error", words}}, status);
}

Answer answer_of(const Response& response, bool head_only, bool keep_alive,
                 std::optional<std::string_view> known) {
  const std::string tag = response.etag.empty() ? "" : "\"" + response.etag + "\"";
  const bool unchanged = response.status == 200 && !tag.empty() && known && known->find(tag) != known->npos;
  const int status = unchanged ? 304 : response.status;
  const auto reason = http::obsolete_reason(http::int_to_status(static_cast<unsigned>(status)));
  Answer answer;
  answer.head = fmt::format("HTTP/1.1 {} {}\r\n{}", status, std::string_view(reason.data(), reason.size()),
                            more_fields(status, response));
  if (!unchanged) {
    answer.head += fmt::format("Content-Type: {}\r\nContent-Length: {}\r\n", response.type,
                               response.body ? response.body->size() : 0);
  }
  if (!tag.empty()) answer.head += fmt::format("ETag: {}\r\n", tag);
  answer.head += fmt::format("Cache-Control: {}\r\nContent-Security-Policy: {}\r\n{}Connection: {}\r\n\r\n",
                             tag.empty() ? "no-store" : "private, no-cache",
                             response.policy.empty() ? kPolicy : response.policy, kGuards,
                             keep_alive ? "keep-alive" : "close");
  if (!head_only && !unchanged) answer.body = response.body;
  return answer;
}

std::string events_head() {
  return fmt::format(
      "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: "
      "no-store\r\nContent-Security-Policy: {}\r\n{}Connection: close\r\n\r\nretry: 1000\n\n",
      kPolicy, kGuards);
}

std::string_view overload_answer() {
  return "HTTP/1.1 503 Service Unavailable\r\nRetry-After: 1\r\nContent-Length: 0\r\nConnection: "
         "close\r\n\r\n";
}

}  // namespace strobe::web
