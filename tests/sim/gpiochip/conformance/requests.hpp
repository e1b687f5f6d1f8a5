// What a conformance program asks whoever watches it to do: its lines "please: C 1 0", "please: B 1 0 x 1500", which is
// as much 1500 times over, and "please: unplug".
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace strobe::testing::conformance {

struct Request {
  char line = 'C';
  std::vector<int> levels;  ///< for that line, one after the other
  int times = 1;
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
    if (!request.unplug) request.line = what.front();
    for (std::string word; words >> word;) {
      if (word == "x")
        words >> request.times;
      else
        request.levels.push_back(std::stoi(word));
    }
    requests.push_back(request);
  }
  return requests;
}

}  // namespace strobe::testing::conformance
