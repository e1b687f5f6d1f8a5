// Which function answers which path. Filled before the server starts, then only read: thread-safe from there
// on.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host/web/http/message.hpp"

namespace strobe::web {

enum class Work {
  quick,  ///< on the network's thread: microseconds
  slow,   ///< on the worker's thread; when too much waits for it, the answer is 503
  waits,  ///< likewise on a worker of its own, which slow work does not hold up: a second at most
  lasts,  ///< likewise, of which nobody else waits for the end: a minute or more
};

class Router {
 public:
  using Handler = std::function<Response(const Request&)>;

  /// pattern: "/api/v1/sessions/{session}/shots"; a name in braces matches one part of the path that is not
  /// empty. Of several patterns that match the one with the fewest names counts, of those the first. What is
  /// got with GET is also told with HEAD.
  void get(std::string pattern, Work work, Handler handler) {
    add("GET", std::move(pattern), work, std::move(handler));
  }
  void post(std::string pattern, Work work, Handler handler) {
    add("POST", std::move(pattern), work, std::move(handler));
  }

  struct Found {
    int status = 200;  ///< 404: no such path; 405: not with this method
    Work work = Work::quick;
    const Handler* handler = nullptr;  ///< lives as long as the router; null unless status is 200
  };
  /// Fills the request's parameters.
  Found find(Request& request) const;
  /// The answer; 404, 405, or 500 with the words of an exception.
  Response route(Request& request) const;

  static Response answer(const Found& found, const Request& request);

 private:
  struct Route {
    std::string method, pattern;
    Work work;
    Handler handler;
  };
  void add(std::string method, std::string pattern, Work work, Handler handler);

  std::vector<Route> routes_;
};

}  // namespace strobe::web
