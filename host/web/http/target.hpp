// The target of a request: path and query, decoded. Pure; thread-safe; allocates.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe::web {

struct Target {
  std::string path;
  std::map<std::string, std::string> query;
};

/// "/path?name=value&…", each part decoded (RFC 3986; + in the query is a blank). Fails unless it begins with '/', all
/// escapes are whole, and what comes out is UTF-8 without control characters. Of a name that comes twice the first counts.
Result<Target> parse_target(std::string_view text);

/// Whether it is UTF-8 (RFC 3629), without control characters.
bool is_plain_text(std::string_view text);

}  // namespace strobe::web
