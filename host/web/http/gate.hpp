// From a request's head to what is done with it. Thread-safe; no I/O.
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "host/web/http/access.hpp"
#include "host/web/http/files.hpp"
#include "host/web/http/request.hpp"
#include "host/web/http/router.hpp"

namespace strobe::web {

inline constexpr std::string_view kEventsPath = "/api/v1/events";

/// The viewer has shown the secret: he is given a cookie and sent to the page.
struct Welcome {
  std::string cookie;
};

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
  Gate(Access access, const Router& router, Files files)
      : access_(std::move(access)), router_(router), files_(std::move(files)) {}

  std::variant<Response, Welcome, Admitted> on_head(const RequestHead& head) const;

 private:
  Access access_;
  const Router& router_;
  Files files_;
};

}  // namespace strobe::web
