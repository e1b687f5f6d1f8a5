// The same numbers from every compiler and level of optimization: the library as built here against programs
// of the same sources built otherwise (-O0, -O3, and clang++ -O2 where there is one).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/common/numerics/compilers/fixed_grid.hpp"

#include <CppUTest/TestHarness.h>

using strobe::numerics::fixed_grid;
using strobe::numerics::GridValue;

namespace {

std::vector<GridValue> grid_of(const std::string& program) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(program.c_str(), "r"), pclose);
  std::vector<GridValue> values;
  char line[200];
  while (pipe && std::fgets(line, sizeof line, pipe.get()) != nullptr) {
    const std::string text = line;
    const std::size_t tab = text.find('\t');
    if (tab == std::string::npos) return {};
    values.push_back({text.substr(0, tab), std::strtod(text.c_str() + tab + 1, nullptr)});
  }
  return values;
}

double ulps_apart(double a, double b) {
  if (a == b) return 0.0;
  const double size = std::max(std::abs(a), std::abs(b));
  return std::abs(a - b) / (std::nextafter(size, std::numeric_limits<double>::infinity()) - size);
}

/// Closed forms and the contact's integration do the same operations in the same order whatever compiles
/// them, and call the same mathematical library. Matrices may be summed in the order that suits a vector unit
/// (on x86-64 without further options they are not: 0 ulps measured): a few roundings, magnified by the fit's
/// condition (tens).
double limit_of(const std::string& form) {
  const bool by_matrices = form == "reduction, values" || form == "reduction, sd" || form == "cubic fit";
  return by_matrices ? 64.0 : 0.0;
}

void compare_with(const std::string& program) {
  const auto own = fixed_grid();
  const auto other = grid_of(program);
  LONGS_EQUAL(own.size(), other.size());
  std::map<std::string, double> worst;
  for (std::size_t i = 0; i < own.size(); ++i) {
    CHECK_TEXT(std::isfinite(own[i].value), own[i].form.c_str());
    double& apart = worst[own[i].form];
    apart = std::max(apart, ulps_apart(own[i].value, other[i].value));
  }
  for (const auto& [form, apart] : worst) {
    std::printf("  %-28s %6.0f ulps\n", form.c_str(), apart);
    CHECK_TEXT(apart <= limit_of(form), form.c_str());
  }
}

}  // namespace

TEST_GROUP(Compilers){};

TEST(Compilers, WithoutOptimizationTheNumbersAreTheSame) { compare_with(STROBE_GRID_O0); }

#ifdef STROBE_GRID_CLANG
TEST(Compilers, ClangGivesTheSameNumbers) { compare_with(STROBE_GRID_CLANG); }
#endif
