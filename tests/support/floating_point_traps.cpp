#include "tests/support/floating_point_traps.hpp"

#include <fenv.h>

namespace strobe::testing {

FloatingPointTraps::FloatingPointTraps() {
  std::feholdexcept(&before_);
  feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
}

FloatingPointTraps::~FloatingPointTraps() { std::fesetenv(&before_); }

}  // namespace strobe::testing
