// What most tests on a bench expect first. For tests: CppUTest's header is the last one.
#pragma once

#include "tests/hil/rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::hil {

inline void expect_ready(RigFixture& bench) {
  if (!bench.ready()) FAIL(("strobed did not come up:\n" + bench.log()).c_str());
}

/// One whose strobed has come up.
struct ReadyRig : RigFixture {
  explicit ReadyRig(const RigFixtureOptions& options = {}) : RigFixture(options) { expect_ready(*this); }
};

/// A command run to its end, which must come with this exit status.
inline testing::CompletedProcess ran(const testing::Command& command, int code = 0) {
  auto done = testing::run_process(command, kLongestWait);
  CHECK_TEXT(done.status == testing::ExitStatus({code, 0}), (done.out + done.err).c_str());
  return done;
}

}  // namespace strobe::hil
