// Who may ask: the secret, and that the asker is a program of this machine's user or this very page, not
// another site's page in the same browser (cross-site requests, DNS rebinding). Plain values; thread-safe; no
// I/O.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/web/http/message.hpp"

namespace strobe::web {

/// Of a request, before its body is read. The views are of the connection's buffer.
struct RequestHead {
  std::string_view method, target;
  std::vector<std::string_view> hosts;  ///< each Host field; one is right
  std::optional<std::string_view> origin, authorization, cookie, content_type;
  std::optional<std::string_view> etag;           ///< If-None-Match
  std::optional<std::string_view> last_event_id;  ///< where a viewer of the event stream was
  std::optional<std::string_view> fetch_site, fetch_mode, fetch_dest;  ///< Sec-Fetch-…, which browsers send
};

struct AccessSettings {
  bool loopback_only = true;  ///< Host must be a name or address of the loopback interface
  std::string machine;        ///< this machine's name, which is a right Host as well if not loopback_only
  std::string secret;         ///< empty: none is needed
  std::uint16_t port = 0;     ///< in the cookie's name, since browsers do not keep ports apart
};

class Access {
 public:
  explicit Access(AccessSettings settings);

  /// A refusal of status 400, 401, 403, 405 or 415; absent: the request is answered. Order of checks: Host,
  /// Origin, method, secret, content type.
  std::optional<Response> check(const RequestHead& head) const;
  /// Of the page opened with the right secret in its address: the cookie to be set, before the page is opened
  /// without it. Only for a request whose Host and Origin are right; absent: it is no such request.
  std::optional<std::string> cookie_for(const RequestHead& head) const;

 private:
  std::optional<Response> check_site(const RequestHead& head) const;
  bool is_own_host(std::string_view host) const;
  bool has_secret(const RequestHead& head) const;
  bool is_secret(std::string_view given) const;

  AccessSettings settings_;
  std::string cookie_;  ///< its name
};

/// 256 random bits as letters, digits, - and _.
std::string random_secret();

}  // namespace strobe::web
