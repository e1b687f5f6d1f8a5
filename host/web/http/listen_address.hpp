// Where the page is served, as a person writes it. Pure; thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe::web {

struct ListenAddress {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8650;

  bool operator==(const ListenAddress&) const = default;
};

/// "ADDRESS:PORT", one of the two, or nothing: what is left out is the default. An address is in figures, that of IPv6 in
/// brackets; "localhost" is 127.0.0.1. Port 0: any that is free. Fails with what was given and an example.
Result<ListenAddress> parse_listen_address(std::string_view text);

}  // namespace strobe::web
