// Fifty decimal digits for references, and the comparison of a double with one.
#pragma once

#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <optional>
#include <string>

#include "tests/common/numerics/forms/digits.hpp"

namespace strobe::numerics {

using Wide = boost::multiprecision::number<boost::multiprecision::cpp_bin_float_50::backend_type,
                                           boost::multiprecision::et_off>;

inline const Wide& wide_pi() {
  static const Wide pi = boost::math::constants::pi<Wide>();
  return pi;
}

/// Error of `got` in units of the larger of |want| and `scale`. A scale of 0 asks for relative accuracy.
inline double error_of(double got, const Wide& want, const Wide& scale) {
  if (!std::isfinite(got)) return std::numeric_limits<double>::infinity();
  const Wide size = abs(want) > scale ? Wide(abs(want)) : scale;
  // 1e-35 of what cancelled to give a zero is all that 50 digits leave of it.
  if (size < Wide(1e-300)) return std::abs(got) < 1e-300 ? 0.0 : std::numeric_limits<double>::infinity();
  return static_cast<double>(abs(Wide(got) - want) / size);
}

inline void compare(Tally& tally, const std::string& output, double got, std::optional<double> textbook,
                    const Wide& want, const Wide& scale) {
  const double error = error_of(got, want, scale);
  const double size = static_cast<double>(abs(want) > scale ? Wide(abs(want)) : scale);
  const double ulp = std::nextafter(size, std::numeric_limits<double>::infinity()) - size;
  const double ulps = error == 0.0 ? 0.0 : error * (size / ulp);
  tally.record(output, error, ulps,
               textbook ? std::optional(error_of(*textbook, want, scale)) : std::nullopt);
}

}  // namespace strobe::numerics
