// Every closed form against 50 digits; `strobe-bench digits` does the same with more samples and prints them.
#include "tests/common/numerics/forms/digits.hpp"

#include <cstdio>

#include "tests/common/numerics/forms/wide_pulse.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::numerics;

namespace {

constexpr std::uint64_t kSeed = 20261121;
constexpr std::size_t kSamples = 600;

void check_forms(const std::vector<Form>& forms) {
  for (const Form& form : forms) {
    for (const Measured& row : measure(form, kSamples, kSeed)) {
      char text[60];
      std::snprintf(text, sizeof text, " error %.3g, seed %llu, at ", row.worst.error,
                    static_cast<unsigned long long>(kSeed));
      CHECK_TEXT(row.worst.error <= row.tolerance,
                 (row.form + ", " + row.output + text + row.worst.argument).c_str());
    }
  }
}

}  // namespace

TEST_GROUP(Digits){};

TEST(Digits, EveryClosedFormKeepsThirteenDigitsOverItsRange) { check_forms(all_forms()); }

// A reference that is wrong would be met by a wrong form: the Taylor series against the closed integrals
// where those do not cancel in 50 digits.
TEST(Digits, TheReferencesIntegralsAgreeWithTheClosedOnes) {
  for (const double damping : {0.0, 0.046, 0.4745, 1.0, 10.0}) {
    for (const double theta : {0.1, 1.0, 3.0}) {
      const Wide f = damping, t = theta, q = 1 + f * f, decay = exp(-f * t);
      const WideIntegrals taylor = taylor_integrals(f, t);
      const Wide first = (1 - decay * (f * sin(t) + cos(t))) / q;
      const Wide second = t / q - (decay * ((1 - f * f) * sin(t) - 2 * f * cos(t)) + 2 * f) / (q * q);
      CHECK(abs(taylor.first - first) < first * Wide(1e-33));
      CHECK(abs(taylor.second - second) < second * Wide(1e-33));
    }
  }
}

TEST(Digits, AFormThatLosesDigitsIsFound) {
  const Form lossy{"1 - cos", "itself", "", {logarithmic("x", 1e-6, 1.0)}, [](auto x, Tally& tally) {
                     const Wide half = sin(Wide(x[0]) / 2);
                     compare(tally, "value", 2.0 * std::pow(std::sin(x[0] / 2.0), 2), 1.0 - std::cos(x[0]),
                             2 * half * half, 0);
                   }};
  const auto rows = measure(lossy, 100, 1);
  LONGS_EQUAL(1, rows.size());
  LONGS_EQUAL(100, rows[0].worst.samples);
  CHECK(rows[0].worst.error < 1e-15);
  CHECK(*rows[0].worst.textbook_error > 1e-6);
}

TEST(Digits, TheSameSeedGivesTheSameRows) {
  const Form form = all_forms().front();
  const auto once = measure(form, 50, 7);
  const auto again = measure(form, 50, 7);
  CHECK_EQUAL(once[0].worst.argument, again[0].worst.argument);
  CHECK_EQUAL(again[0].worst.error, once[0].worst.error);
}
