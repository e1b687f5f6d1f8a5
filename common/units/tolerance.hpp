// Relative tolerances as a person writes them: "0.5%", "5e-3". Pure; thread-safe; the texts allocate.
#pragma once

#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe {

/// 100 %: as large as the number itself.
inline constexpr double kLargestTolerance = 1.0;

/// A relative tolerance, a plain decimal number or a percentage: "5e-3" and "0.5%" are the same double, to
/// the last bit. Blanks around it and before the sign are ignored. Valid: above 0, at most 1 (100%).
/// The error quotes the text and says what is wrong; the caller adds the option's or the key's name.
Result<double> parse_tolerance(std::string_view text);

/// "0.5%": the shortest percentage that parse_tolerance() reads as the same double. Valid: as above.
std::string tolerance_text(double tolerance);

}  // namespace strobe
