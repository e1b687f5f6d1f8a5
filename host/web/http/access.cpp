#include "host/web/http/access.hpp"

#include <arpa/inet.h>
#include <sodium.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <utility>

namespace strobe::web {
namespace {

bool equal_without_case(std::string_view a, std::string_view b) {
  return a.size() == b.size() && strncasecmp(a.data(), b.data(), a.size()) == 0;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// "[::1]:8650" → "::1"; without the port, which a forwarded one may differ from. Empty: it is no host.
std::string name_of(std::string_view host) {
  const bool bracketed = host.starts_with('[');
  const std::size_t end = std::min(host.find(bracketed ? ']' : ':'), host.size());
  if (bracketed && end == host.size()) return "";
  const std::string_view rest = host.substr(end + (bracketed ? 1 : 0));
  const bool has_port =
      rest.starts_with(':') && rest.size() <= 6 && rest.find_first_not_of("0123456789", 1) == rest.npos;
  return rest.empty() || has_port ? std::string(host.substr(bracketed ? 1 : 0, end - (bracketed ? 1 : 0)))
                                  : "";
}

bool is_address(const std::string& name) {
  in6_addr address{};
  return inet_pton(AF_INET, name.c_str(), &address) == 1 || inet_pton(AF_INET6, name.c_str(), &address) == 1;
}

bool is_loopback(const std::string& name) {
  in_addr address{};
  if (inet_pton(AF_INET, name.c_str(), &address) == 1) return ntohl(address.s_addr) >> 24 == 127;
  return name == "::1" || equal_without_case(name, "localhost");
}

bool asks_for_page(const RequestHead& head) {
  return head.method == "GET" && head.fetch_mode == "navigate" && head.fetch_dest == "document";
}

using Hash = std::array<unsigned char, crypto_generichash_BYTES>;

Hash hash_of(std::string_view text) {
  Hash hash{};
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(text.data()),
                     text.size(), nullptr, 0);
  return hash;
}

}  // namespace

Access::Access(AccessSettings settings)
    : settings_(std::move(settings)), cookie_("strobe_" + std::to_string(settings_.port)) {}

std::optional<Response> Access::check(const RequestHead& head) const {
  if (auto refused = check_site(head)) return refused;
  if (head.method != "GET" && head.method != "HEAD" && head.method != "POST")
    return error_response(405, "only GET, HEAD and POST");
  if (!has_secret(head))
    return error_response(
        401, "open the address that strobe printed, with its secret, or send it as Authorization: Bearer");
  if (head.method == "POST") {
    const std::string_view type = head.content_type.value_or("");
    if (!equal_without_case(trimmed(type.substr(0, type.find(';'))), "application/json"))
      return error_response(415, "Content-Type must be application/json");
  }
  return std::nullopt;
}

std::optional<Response> Access::check_site(const RequestHead& head) const {
  if (head.hosts.size() != 1) return error_response(400, "one Host is needed");
  const std::string_view host = trimmed(head.hosts[0]);
  if (!is_own_host(host)) return error_response(403, "this Host is not served here");
  if (head.origin && !equal_without_case(trimmed(*head.origin), "http://" + std::string(host)))
    return error_response(403, "another site's pages may not ask");
  const bool foreign = head.fetch_site && *head.fetch_site != "same-origin" && *head.fetch_site != "none";
  if (foreign && !asks_for_page(head)) return error_response(403, "another site's pages may not ask");
  return std::nullopt;
}

/// A name that a stranger's name server gives this machine's address to is not its own.
bool Access::is_own_host(std::string_view host) const {
  const std::string name = name_of(host);
  if (name.empty() || settings_.loopback_only || is_loopback(name)) return is_loopback(name);
  return is_address(name) || (!settings_.machine.empty() && equal_without_case(name, settings_.machine));
}

bool Access::has_secret(const RequestHead& head) const {
  if (settings_.secret.empty()) return true;
  if (head.authorization) {
    constexpr std::string_view kScheme = "bearer ";
    const std::string_view given = *head.authorization;
    if (equal_without_case(given.substr(0, kScheme.size()), kScheme))
      return is_secret(trimmed(given.substr(kScheme.size())));
  }
  std::string_view rest = head.cookie.value_or("");
  while (!rest.empty()) {
    const std::string_view pair = trimmed(rest.substr(0, rest.find(';')));
    rest.remove_prefix(std::min(rest.size() - 1, rest.find(';')) + 1);
    if (pair.starts_with(cookie_ + "=") && is_secret(pair.substr(cookie_.size() + 1))) return true;
  }
  return false;
}

std::optional<std::string> Access::cookie_for(const RequestHead& head) const {
  if (settings_.secret.empty() || head.method != "GET" || check_site(head)) return std::nullopt;
  const auto target = parse_target(head.target);
  if (!target || target->path != "/") return std::nullopt;
  const auto given = target->query.find("secret");
  if (given == target->query.end() || !is_secret(given->second)) return std::nullopt;
  return cookie_ + "=" + settings_.secret + "; Path=/; HttpOnly; SameSite=Strict";
}

/// Takes as long for any that is wrong: hashes of a fixed size are compared.
bool Access::is_secret(std::string_view given) const {
  const Hash right = hash_of(settings_.secret), presented = hash_of(given);
  return sodium_memcmp(right.data(), presented.data(), right.size()) == 0;
}

std::string random_secret() {
  if (sodium_init() < 0) return "";  // then nobody is let in: see PageServer::open()
  std::array<unsigned char, 32> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  std::array<char, 64> text{};
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(),
                    sodium_base64_VARIANT_URLSAFE_NO_PADDING);
  return text.data();
}

}  // namespace strobe::web
