// What a conformance program asks whoever watches it to do: its lines "please: C 1 0" and "please: unplug".
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace strobe::testing::conformance {

struct Request {
  std::vector<int> levels;  ///< for line C, one after the other
  bool unplug = false;
};

/// All whole lines of that kind so far.
inline std::vector<Request> requests_in(const std::string& output) {
  std::vector<Request> requests;
  for (std::size_t at = 0, end = 0; (end = output.find('\n', at)) != std::string::npos; at = end + 1) {
    std::istringstream words(output.substr(at, end - at));
    std::string please, what;
    if (!(words >> please >> what) || please != "please:") continue;
    Request request;
    request.unplug = what == "unplug";
    for (int level = 0; words >> level;) request.levels.push_back(level);
    requests.push_back(request);
  }
  return requests;
}

}  // namespace strobe::testing::conformance
