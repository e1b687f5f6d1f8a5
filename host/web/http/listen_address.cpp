#include "host/web/http/listen_address.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace strobe::web {
namespace {

bool all_digits(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

std::optional<std::uint16_t> port_of(std::string_view text) {
  std::uint16_t port = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), port);
  if (!all_digits(text) || read.ec != std::errc()) return std::nullopt;
  return port;
}

bool is_address(int family, const std::string& text) {
  in6_addr address{};
  return inet_pton(family, text.c_str(), &address) == 1;
}

/// Takes the address off the text's front, brackets and all.
std::optional<std::string> take_address(std::string_view& text) {
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == text.npos) return std::nullopt;
    const std::string address(text.substr(1, end - 1));
    text.remove_prefix(end + 1);
    return is_address(AF_INET6, address) ? std::optional(address) : std::nullopt;
  }
  const std::string address(text.substr(0, text.find(':')));
  text.remove_prefix(address.size());
  if (address == "localhost") return "127.0.0.1";
  return is_address(AF_INET, address) ? std::optional(address) : std::nullopt;
}

}  // namespace

Result<ListenAddress> parse_listen_address(std::string_view text) {
  const auto wrong = [given = text] {
    return fail(fmt::format("\"{}\" is not ADDRESS:PORT, such as 127.0.0.1:8650 or [::1]:8650", given));
  };
  ListenAddress where;
  if (text.empty()) return where;
  if (all_digits(text)) {
    const auto port = port_of(text);
    if (!port) return wrong();
    where.port = *port;
    return where;
  }
  const auto address = take_address(text);
  if (!address) return wrong();
  where.address = *address;
  if (text.empty()) return where;
  const auto port = text[0] == ':' ? port_of(text.substr(1)) : std::nullopt;
  if (!port) return wrong();
  where.port = *port;
  return where;
}

}  // namespace strobe::web
