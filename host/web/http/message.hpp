// What the page's interface is asked and what it answers: as values, without the network, and as the bytes of
// an answer. Plain values and pure functions; thread-safe; they allocate.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "common/result.hpp"

namespace strobe::web {

inline constexpr std::size_t kMaxBody_bytes = 256 * 1024;

struct Request {
  std::string method;                        ///< "GET", "HEAD" or "POST"
  std::string path;                          ///< decoded, without the query; UTF-8 without control characters
  std::map<std::string, std::string> query;  ///< decoded, likewise
  std::map<std::string, std::string> parameters;  ///< what the route's {names} matched, decoded
  std::string body;                               ///< any bytes, at most kMaxBody_bytes
  std::string from;                               ///< the viewer's address, such as "127.0.0.1"
};

struct Target {
  std::string path;
  std::map<std::string, std::string> query;
};

/// "/path?name=value&…", each part decoded (RFC 3986; + in the query is a blank). Fails unless it begins with
/// '/', all escapes are whole, and what comes out is UTF-8 without control characters. Of a name that comes
/// twice the first counts.
Result<Target> parse_target(std::string_view text);

/// Whether it is UTF-8 (RFC 3629), without control characters.
bool is_plain_text(std::string_view text);

struct Response {
  int status = 200;
  std::string type = "application/json";
  std::shared_ptr<const std::string> body{};  ///< null: empty
  /// Names this content; a viewer that has it is not sent it again. Empty: it is never kept by a viewer.
  std::string etag{};
  /// Content-Security-Policy in place of the server's own, for documents that hold their own style. Empty:
  /// the server's.
  std::string policy{};
  std::string cookie{};  ///< to be set, with status 303, which sends the viewer to the page
};

/// Bytes that are no UTF-8 are replaced.
Response json_response(const nlohmann::ordered_json& json, int status = 200);
/// JSON that is text already.
Response json_text_response(std::string json, int status = 200);
/// {"error": words}
Response error_response(int status, std::string_view words);

/// Why a request cannot be answered.
struct Unanswered {
  int status = 500;   ///< of HTTP: 400, 404, 409, 422, 500
  std::string words;  ///< one line
};
template <typename T>
using Answered = tl::expected<T, Unanswered>;
inline tl::unexpected<Unanswered> unanswered(int status, std::string words) {
  return tl::unexpected<Unanswered>(Unanswered{status, std::move(words)});
}
inline Response error_response(const Unanswered& why) { return error_response(why.status, why.words); }

/// What goes over the wire.
struct Answer {
  std::string head;                         ///< with the empty line
  std::shared_ptr<const std::string> body;  ///< null: none
};
/// keep_alive: whether the connection stays open. known: what If-None-Match says; where that is the content's
/// name, the answer is 304 and has no body.
Answer answer_of(const Response& response, bool head_only, bool keep_alive,
                 std::optional<std::string_view> known = {});
/// Of the event stream, which ends with its connection.
std::string events_head();
/// All of a refusal that is sent where there is no time for more.
std::string_view overload_answer();

}  // namespace strobe::web
