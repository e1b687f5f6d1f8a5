// What the page's interface is asked and what it answers, without the network. Plain values.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

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

struct Response {
  int status = 200;
  std::string type = "application/json";
  std::shared_ptr<const std::string> body;  ///< null: empty
  /// Names this content; a viewer that has it is not sent it again. Empty: it is never kept by a viewer.
  std::string etag{};
  /// Content-Security-Policy in place of the server's own, for documents that hold their own style. Empty: the server's.
  std::string policy{};
};

/// Bytes that are no UTF-8 are replaced.
Response json_response(const nlohmann::ordered_json& json, int status = 200);
/// JSON that is text already.
Response json_text_response(std::string json, int status = 200);
/// {"error": words}
Response error_response(int status, std::string_view words);

}  // namespace strobe::web
