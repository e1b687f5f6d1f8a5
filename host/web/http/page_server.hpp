// Serves the page and its interface over HTTP, on threads of its own that the host's own work goes before.
// Reads and writes sockets; the object belongs to one thread.
//
// Limits: a request's head 16 kB, its body 256 kB; 200 connections, of which those that have shown no right
// to ask are closed first; 20 viewers of the event stream; one slow request at a time, 16 waiting. What is
// beyond is answered 503, what is malformed 400.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "common/result.hpp"
#include "host/web/http/event_hub.hpp"
#include "host/web/http/router.hpp"

namespace strobe::web {

/// Where the page is served.
struct ListenAddress {
  std::string address = "127.0.0.1";  ///< IPv4 or IPv6, in figures
  std::uint16_t port = 8650;          ///< 0: any that is free

  bool operator==(const ListenAddress&) const = default;
};

/// "ADDRESS:PORT", one of the two, or nothing: what is left out is the default. An address is in figures,
/// that of IPv6 in brackets; "localhost" is 127.0.0.1. Port 0: any that is free. Fails with what was given
/// and an example.
Result<ListenAddress> parse_listen_address(std::string_view text);

/// How long a viewer may take.
struct Patience {
  std::chrono::milliseconds first_request{5000};  ///< from connecting to a whole request
  std::chrono::milliseconds request{10000};       ///< from a later request's first byte to its last
  std::chrono::milliseconds idle{60000};          ///< between requests
  std::chrono::milliseconds write{10000};         ///< to read an answer, or a part of the event stream
};

struct Limits {
  std::size_t connections = 200;
  std::size_t viewers = 20;        ///< of the event stream
  std::size_t slow_requests = 16;  ///< that wait, of each worker
  Patience patience;
};

struct ServerSettings {
  ListenAddress where;
  Limits limits{};
};

class PageServer {
 public:
  /// Router and hub must outlive the server; nothing is added to the router any more. Fails with a line that
  /// names address and port.
  static Result<std::unique_ptr<PageServer>> open(const ServerSettings& settings, const Router& router,
                                                  EventHub& hub);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  std::uint16_t port() const;
  /// "http://127.0.0.1:8650/"
  std::string url() const;
  /// Likewise, with the secret if one is needed: for the eyes of the person who started the program.
  std::string url_with_secret() const;
  const std::string& secret() const;

  /// Tells the viewers of the event stream (`end`) and closes, within half a second. False if a slow request
  /// goes on: then what its handler uses, the router included, must be left as it is, and the process ended
  /// by _exit().
  bool end();

 private:
  class Implementation;
  explicit PageServer(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace strobe::web
