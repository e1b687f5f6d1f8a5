// A test that nothing can be said by on this machine counts as skipped: neither passed nor failed.
#pragma once

#include <string>

namespace strobe::testing {

/// What ctest takes for skipped (SKIP_RETURN_CODE), if nothing failed.
inline constexpr int kSkipped = 77;

/// Says why in a line; the test is to return.
void skip(const std::string& why);
/// The exit status of a program with so many failures.
int exit_status(int failures);

}  // namespace strobe::testing
