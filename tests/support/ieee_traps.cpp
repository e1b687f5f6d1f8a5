#include "tests/support/ieee_traps.hpp"

#include <fenv.h>

namespace strobe::testing {

IeeeTraps::IeeeTraps() {
  std::feholdexcept(&before_);
  feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
}

IeeeTraps::~IeeeTraps() { std::fesetenv(&before_); }

}  // namespace strobe::testing
