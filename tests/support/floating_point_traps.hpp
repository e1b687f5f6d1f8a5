// Traps of floating-point exceptions for the length of a scope: an operation that makes a NaN out of numbers,
// divides by zero or overflows kills the test (SIGFPE) where it happens, instead of passing on a value that
// nothing may notice. Underflow and rounding are everyday business and stay silent. Per thread.
#pragma once

#include <cfenv>

namespace strobe::testing {

class FloatingPointTraps {
 public:
  FloatingPointTraps();
  /// The environment is as it was before, flags that were raised silently included.
  ~FloatingPointTraps();
  FloatingPointTraps(const FloatingPointTraps&) = delete;
  FloatingPointTraps& operator=(const FloatingPointTraps&) = delete;

 private:
  std::fenv_t before_;
};

/// The same exceptions as flags: true if the call raised one. For a message that names the arguments; the
/// flags are clear afterwards.
template <typename Call>
bool raises_exception(Call&& call) {
  std::feclearexcept(FE_ALL_EXCEPT);
  call();
  const bool raised = std::fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW) != 0;
  std::feclearexcept(FE_ALL_EXCEPT);
  return raised;
}

}  // namespace strobe::testing
