// From a request's head to what is done with it: the interface's paths, the event stream, and the page's
// files, which were built into the program. Thread-safe; no I/O.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "host/web/http/access.hpp"
#include "host/web/http/message.hpp"
#include "host/web/http/router.hpp"

namespace strobe::web {

/// One that was built in; the views live as long as the program.
struct EmbeddedFile {
  std::string_view name;  ///< "app.js", "icons/ball.svg"
  std::string_view hash;  ///< of the content
  std::string_view content;
};

inline constexpr std::string_view kEventsPath = "/api/v1/events";

/// It will be answered once its body is there.
struct Admitted {
  Request request;      ///< without body and address
  Router::Found found;  ///< of the interface's paths; not of files and the event stream
  std::optional<Response> file;
  bool events = false;  ///< the event stream is asked for
};

class Gate {
 public:
  /// The router must outlive the gate.
  Gate(Access access, const Router& router) : access_(std::move(access)), router_(router) {}

  /// A refusal, or the cookie of who has shown the secret: he is sent to the page. Else it is admitted.
  std::variant<Response, Admitted> on_head(const RequestHead& head) const;

 private:
  Access access_;
  const Router& router_;
};

}  // namespace strobe::web
