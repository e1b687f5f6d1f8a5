// The first check of most tests on a bench.
#pragma once

#include <CppUTest/TestHarness.h>

#include "tests/hil/rig_fixture.hpp"

namespace strobe::hil {

inline void expect_ready(RigFixture& bench) {
  if (!bench.ready()) FAIL(("strobed did not come up:\n" + bench.log()).c_str());
}

}  // namespace strobe::hil
