// Prints the grid as "form<TAB>value in hexadecimal", for the comparison of compilers.
#include <cstdio>

#include "tests/common/numerics/compilers/fixed_grid.hpp"

int main() {
  for (const auto& v : strobe::numerics::fixed_grid()) std::printf("%s\t%a\n", v.form.c_str(), v.value);
}
