// Properties, checked by rapidcheck: numbers drawn over the whole of their ranges from the first draw on (a generator
// by itself begins with the least), and a record of what the draws showed.
// RC_PARAMS="max_success=N" sets how many there are; a failure prints what repeats it. STROBE_PROPERTIES names a
// file to which each property adds a line: group and name, draws, the worst deviation and its tolerance, separated by tabs.
#pragma once

#include <rapidcheck.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <ostream>

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::testing {

/// Of 0…1, ends included.
inline double fraction() { return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, 1'000'001)) / 1e6; }
inline double between(double low, double high) { return low + (high - low) * fraction(); }
/// Evenly in the logarithm.
inline double over_decades(double low, double high) { return low * std::pow(high / low, fraction()); }
/// One time in `count`.
inline bool one_in(int count) { return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, count)) == 0; }
inline double sometimes(double special, double otherwise, int count = 6) { return one_in(count) ? special : otherwise; }

/// Deviations beside their tolerances, of which that is kept which is the worst for its tolerance.
class Worst {
 public:
  /// Whether the deviation is within the tolerance; a NaN is not.
  bool within(double deviation, double tolerance) {
    const double share = deviation == 0.0 ? 0.0 : deviation / tolerance;
    if (!(share <= share_)) {
      share_ = std::isnan(share) ? HUGE_VAL : share;
      deviation_ = deviation;
      tolerance_ = tolerance;
    }
    const bool holds = deviation <= tolerance;
    if (!holds) RC_LOG() << "deviation " << deviation << ", tolerance " << tolerance << '\n';
    return holds;
  }

  /// "deviation<tab>tolerance", or "-<tab>-" where nothing was compared.
  friend std::ostream& operator<<(std::ostream& out, const Worst& worst) {
    if (worst.share_ < 0.0) return out << "-\t-";
    return out << worst.deviation_ << '\t' << worst.tolerance_;
  }

 private:
  double share_ = -1.0, deviation_ = 0.0, tolerance_ = 0.0;
};

/// Checks a property(Worst&), or property() without numbers to compare, that holds of all that it draws. Recorded under
/// the test's name; one in a test.
template <typename Property>
bool holds_of_all(Property&& property) {
  const UtestShell& test = *UtestShell::getCurrent();
  const std::string name = std::string(test.getGroup().asCharString()) + "." + test.getName().asCharString();
  Worst worst;
  long draws = 0;
  const bool held = rc::check(name, [&] {
    if constexpr (std::is_invocable_v<Property, Worst&>) {
      property(worst);
    } else {
      property();
    }
    ++draws;
  });
  if (const char* file = std::getenv("STROBE_PROPERTIES")) {
    std::ostringstream line;  // written at once: other programs add theirs
    line.precision(2);
    line << name << '\t' << draws << '\t' << worst << '\t' << (held ? "holds" : "FAILS") << '\n';
    std::ofstream(file, std::ios::app) << line.str() << std::flush;
  }
  return held;
}

}  // namespace strobe::testing
