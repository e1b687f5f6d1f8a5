// How far off a number may be, as a person writes it: "0.5%", "5e-3". Pure; thread-safe; the texts allocate.
#pragma once

#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe {

/// The largest tolerance that is one: as large as the number itself.
inline constexpr double kLargestTolerance = 1.0;

/// A relative tolerance, a plain decimal number or a percentage: "5e-3" and "0.5%" are the same double, to
/// the last bit. Blanks around it and before the sign are passed over. Valid: above 0, at most 1 (100%).
/// The error quotes the text and says what is wrong; the caller puts the option's or the key's name before
/// it.
Result<double> parse_tolerance(std::string_view text);

/// "0.5%": the shortest percentage that parse_tolerance takes back to the same double. Valid: as above.
std::string tolerance_text(double tolerance);

}  // namespace strobe
