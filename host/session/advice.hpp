// What a person can do about a shot that does not count, or whose numbers are doubtful: one table for the
// console, its text files and the page. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <string_view>

#include "common/reduction/flags.hpp"
#include "host/session/shot.hpp"

namespace strobe::host {

/// A sentence or more; empty: nothing need be done. What cut a shot short is told alone, since the rest of
/// what is wrong with it comes of that.
std::string advice(const Shot& shot);

/// Of one flag; empty: nothing need be done.
std::string_view advice(reduction::Flag flag);

/// Of what ended a shot before its plan's end, in the words of the firmware (shot_t) or of the host; empty:
/// of words that it does not know.
std::string_view advice_on_abort(std::string_view reason);

}  // namespace strobe::host
