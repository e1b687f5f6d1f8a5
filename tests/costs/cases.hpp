// What is counted: one case for each piece of work whose cost must not grow unseen. Each does the same in every run.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace strobe::costs {

struct Case {
  std::string name;
  std::function<void()> run;  ///< once before it is counted, once while it is
};

std::vector<Case> all_cases();

}  // namespace strobe::costs
