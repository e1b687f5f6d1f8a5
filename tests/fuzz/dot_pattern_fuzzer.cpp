// Patterns of dots are user files: any bytes are either directions of length one or an error of one line.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "host/digitize/pattern/dot_pattern.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto pattern = strobe::digitize::parse_dot_pattern(text_of(data, size), "fuzz.csv");
  if (!pattern) return require_one_line(pattern.error().message, "fuzz.csv:"), 0;
  require(pattern->dots.size() >= strobe::digitize::kMinPatternDots);
  for (const Eigen::Vector3d& dot : pattern->dots) require(std::abs(dot.norm() - 1.0) < 1e-9);
  return 0;
}
