#include "tests/support/skip.hpp"

#include <cstdio>

namespace strobe::testing {
namespace {

bool skipped = false;

}  // namespace

void skip(const std::string& why) {
  skipped = true;
  std::printf("SKIPPED: %s\n", why.c_str());
}

int exit_status(int failures) { return failures == 0 && skipped ? kSkipped : failures; }

}  // namespace strobe::testing
