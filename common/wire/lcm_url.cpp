#include "common/wire/lcm_url.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

namespace strobe::wire {

namespace {

constexpr std::string_view kScheme = "udpm://";
constexpr std::string_view kDefaultGroup = "239.255.76.67:7667";  // LCM's, where a URL names none
constexpr std::size_t kMaxShown = 100;

std::optional<int> number(std::string_view text, int min, int max) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  const bool plain = text == "0" || (!text.empty() && text[0] >= '1' && text[0] <= '9');
  if (!plain || read.ec != std::errc{} || read.ptr != end || value < min || value > max) return std::nullopt;
  return value;
}

/// What precedes the separator; `text` becomes what follows it, or nullopt if there is none.
std::string_view take_part(std::optional<std::string_view>& text, char separator) {
  const std::string_view whole = *text;
  const std::size_t at = whole.find(separator);
  if (at == whole.npos) {
    text.reset();
    return whole;
  }
  text = whole.substr(at + 1);
  return whole.substr(0, at);
}

bool is_multicast(std::string_view address) {
  std::optional<std::string_view> rest = address;
  const auto first = number(take_part(rest, '.'), 224, 239);
  for (int i = 0; i < 3; ++i) {
    if (!rest || !number(take_part(rest, '.'), 0, 255)) return false;
  }
  return first && !rest;
}

/// What is wrong with ADDRESS:PORT.
std::optional<std::string> read_group(std::string_view where, MulticastGroup& group) {
  std::optional<std::string_view> rest = where;
  const std::string_view address = take_part(rest, ':');
  if (!is_multicast(address)) return "its address is not one from 224.0.0.0 to 239.255.255.255";
  const auto port = rest ? number(*rest, 1, 65535) : std::nullopt;
  if (!rest) return "it has no port";
  if (!port) return "its port is not a number from 1 to 65535";
  group.address = address;
  group.port = static_cast<std::uint16_t>(*port);
  return std::nullopt;
}

/// What is wrong with KEY=N&KEY=N.
std::optional<std::string> read_parameters(std::optional<std::string_view> rest, LcmUrl& url) {
  bool has_ttl = false, has_size = false;
  while (rest) {
    std::optional<std::string_view> value = take_part(rest, '&');
    const std::string_view key = take_part(value, '=');
    const bool is_ttl = key == "ttl", is_size = key == "recv_buf_size";
    if (!is_ttl && !is_size) return "its parameters are ttl and recv_buf_size, no others";
    if (std::exchange(is_ttl ? has_ttl : has_size, true)) return "it has a parameter twice";
    const auto read =
        value ? is_ttl ? number(*value, 0, 255) : number(*value, 1, kMaxReceiveBuffer_bytes) : std::nullopt;
    if (!read) return is_ttl ? "its ttl is not a number from 0 to 255" : "its recv_buf_size is not a number";
    (is_ttl ? url.ttl : url.group.receive_buffer_bytes) = *read;
  }
  return std::nullopt;
}

/// For an error message: one line, of bounded length.
std::string shown(std::string_view text) {
  std::string line(text.substr(0, kMaxShown));
  std::ranges::replace_if(
      line, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text.size() > kMaxShown ? line + "..." : line;
}

std::optional<std::string> read(std::string_view text, LcmUrl& url) {
  if (!text.starts_with(kScheme)) return "it does not begin with udpm://";
  std::optional<std::string_view> parameters = text.substr(kScheme.size());
  const std::string_view where = take_part(parameters, '?');
  if (auto problem = read_group(where.empty() ? kDefaultGroup : where, url.group)) return problem;
  return read_parameters(parameters, url);
}

}  // namespace

Result<LcmUrl> read_lcm_url(std::string_view text) {
  LcmUrl url;
  if (const auto problem = read(text, url))
    return fail("\"" + shown(text) + "\" is no udpm://ADDRESS:PORT?ttl=N&recv_buf_size=N: " + *problem);
  return url;
}

std::string to_text(const LcmUrl& url) {
  std::string text(kScheme);
  text += url.group.address + ":" + std::to_string(url.group.port) + "?ttl=" + std::to_string(url.ttl);
  if (url.group.receive_buffer_bytes > 0)
    text += "&recv_buf_size=" + std::to_string(url.group.receive_buffer_bytes);
  return text;
}

std::string lcm_url_problem(const std::string& text) {
  const auto url = read_lcm_url(text);
  return url ? std::string() : url.error().message;
}

}  // namespace strobe::wire
