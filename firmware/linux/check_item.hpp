// One thing that `strobed --check` looks at.
#pragma once

#include <string>
#include <vector>

namespace strobe::firmware {

struct CheckItem {
  enum class Verdict {
    ok,      ///< text: what was found
    advice,  ///< it runs, but could be better: text says how
    fault    ///< strobed would not start, or miss its times: text says what to do
  };
  std::string name;
  Verdict verdict = Verdict::ok;
  std::string words;                    ///< one line
  std::vector<std::string> paste = {};  ///< lines for root's shell that mend it
};

}  // namespace strobe::firmware
