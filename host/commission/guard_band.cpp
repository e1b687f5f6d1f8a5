#include "host/commission/guard_band.hpp"

namespace strobe::commission {

void hold(StepResult& result, const Interval& found, const Limits& limits, const char* fault,
          const std::string& mend, const std::string& tell) {
  if (found.least >= limits.least && found.most <= limits.most) return;
  if (found.least > limits.most || found.most < limits.least) {
    if (result.state != StepState::failed) mark_failed(result, fault, mend);
  } else if (result.state == StepState::passed) {
    result.state = StepState::not_told;
    result.advice = "its interval reaches over a limit: " + tell + "; if it stays so: " + mend;
  }
}

}  // namespace strobe::commission
