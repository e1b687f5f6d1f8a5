#include "host/web/http/router.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace strobe::web {
namespace {

using Parameters = std::map<std::string, std::string>;

std::string_view take_part(std::string_view& path) {
  path.remove_prefix(1);
  const std::string_view part = path.substr(0, path.find('/'));
  path.remove_prefix(part.size());
  return part;
}

/// Both begin with '/'.
bool matches(std::string_view pattern, std::string_view path, Parameters& parameters) {
  while (!pattern.empty() && !path.empty()) {
    const std::string_view wanted = take_part(pattern), part = take_part(path);
    const bool name = wanted.size() > 2 && wanted.front() == '{' && wanted.back() == '}';
    if (name && part.empty()) return false;
    if (!name && wanted != part) return false;
    if (name) parameters[std::string(wanted.substr(1, wanted.size() - 2))] = std::string(part);
  }
  return pattern.empty() && path.empty();
}

}  // namespace

void Router::add(std::string method, std::string pattern, Work work, Handler handler) {
  routes_.push_back({std::move(method), std::move(pattern), work, std::move(handler)});
}

Router::Found Router::find(Request& request) const {
  const std::string_view method = request.method == "HEAD" ? std::string_view("GET") : request.method;
  Found found{404};
  if (!request.path.starts_with('/')) return found;
  const Route* best = nullptr;
  Parameters best_parameters;
  for (const Route& route : routes_) {
    Parameters parameters;
    if (!matches(route.pattern, request.path, parameters)) continue;
    found.status = 405;
    if (route.method != method) continue;
    if (best != nullptr && parameters.size() >= best_parameters.size()) continue;
    best = &route;
    best_parameters = std::move(parameters);
  }
  if (best == nullptr) return found;
  request.parameters = std::move(best_parameters);
  return {200, best->work, &best->handler};
}

Response Router::answer(const Found& found, const Request& request) {
  if (found.status == 404) return error_response(404, "there is nothing of this name");
  if (found.status != 200) return error_response(found.status, "not with this method");
  try {
    return (*found.handler)(request);
  } catch (const std::exception& error) {
    std::string words = error.what();
    std::ranges::replace(words, '\n', ' ');
    return error_response(500, words);
  }
}

Response Router::route(Request& request) const {
  const Found found = find(request);
  return answer(found, request);
}

}  // namespace strobe::web
