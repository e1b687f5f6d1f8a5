// The head of an answer as it goes over the wire. Pure; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "host/web/http/request.hpp"

namespace strobe::web {

/// keep_alive: whether the connection stays open. known: what If-None-Match says; where that is the content's name, the
/// answer is 304 and has no body.
struct Answer {
  std::string head;                         ///< with the empty line
  std::shared_ptr<const std::string> body;  ///< null: none
};
Answer answer_of(const Response& response, bool head_only, bool keep_alive,
                 std::optional<std::string_view> known = {});
/// 303 to the page, with the cookie.
std::string welcome_head(std::string_view cookie);
/// Of the event stream, which ends with its connection.
std::string events_head();

/// All of a refusal that is sent where there is no time for more.
std::string_view overload_answer();

}  // namespace strobe::web
