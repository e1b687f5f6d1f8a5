// The thesis's text format of digitized frames. Pure functions; thread-safe; they allocate.
//
// Line 1: strobe period in seconds. Then frames, separated by two blank lines, each: a line
// `n_contact frame_number`; four lines `x y` of surface points (1, 2 on the touchdown side, 3, 4 on the
// lift-off side); eight images, seven when n_contact is 1, each a blank line and four lines `x y`: centre, a
// point of the edge, two points of the equator. Images 1-3 before the impact, 4-6 after it, 7-8 in contact.
// Any length unit, y up. Lines may end in CR LF; blanks around numbers do not matter.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/legacy.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

/// Each frame of the file in its order, or what is wrong with it as "FILE:LINE: what"; a bad frame does not
/// hide the ones after it. A file without a period, or without a frame, gives one error.
std::vector<Result<LegacyFrame>> parse_legacy(std::string_view text, const std::string& file_name);

}  // namespace strobe::reduction
