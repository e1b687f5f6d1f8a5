#include "host/web/http/answer.hpp"

#include <fmt/format.h>

namespace strobe::web {
namespace {

constexpr std::string_view kPolicy =
    "default-src 'self'; img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors "
    "'self'";
constexpr std::string_view kGuards =
    "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\nCross-Origin-Opener-Policy: same-origin\r\n";

std::string_view reason_of(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 202:
      return "Accepted";
    case 303:
      return "See Other";
    case 304:
      return "Not Modified";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 409:
      return "Conflict";
    case 411:
      return "Length Required";
    case 413:
      return "Content Too Large";
    case 415:
      return "Unsupported Media Type";
    case 422:
      return "Unprocessable Content";
    case 431:
      return "Request Header Fields Too Large";
    case 500:
      return "Internal Server Error";
    case 503:
      return "Service Unavailable";
    case 505:
      return "HTTP Version Not Supported";
    default:
      return "Answer";
  }
}

std::string_view more_fields(int status) {
  switch (status) {
    case 401:
      return "WWW-Authenticate: Bearer\r\n";
    case 405:
      return "Allow: GET, HEAD, POST\r\n";
    case 503:
      return "Retry-After: 1\r\n";
    default:
      return "";
  }
}

}  // namespace

Answer answer_of(const Response& response, bool head_only, bool keep_alive,
                 std::optional<std::string_view> known) {
  const std::string tag = response.etag.empty() ? "" : "\"" + response.etag + "\"";
  const bool unchanged = response.status == 200 && !tag.empty() && known && known->find(tag) != known->npos;
  const int status = unchanged ? 304 : response.status;
  Answer answer;
  answer.head = fmt::format("HTTP/1.1 {} {}\r\n{}", status, reason_of(status), more_fields(status));
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

std::string welcome_head(std::string_view cookie) {
  return fmt::format(
      "HTTP/1.1 303 See Other\r\nLocation: /\r\nSet-Cookie: {}\r\nContent-Length: 0\r\nCache-Control: "
      "no-store\r\n"
      "{}Connection: keep-alive\r\n\r\n",
      cookie, kGuards);
}

std::string events_head() {
  return fmt::format(
      "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n"
      "Content-Security-Policy: {}\r\n{}Connection: close\r\n\r\nretry: 1000\n\n",
      kPolicy, kGuards);
}

std::string_view overload_answer() {
  return "HTTP/1.1 503 Service Unavailable\r\nRetry-After: 1\r\nContent-Length: 0\r\nConnection: "
         "close\r\n\r\n";
}

}  // namespace strobe::web
