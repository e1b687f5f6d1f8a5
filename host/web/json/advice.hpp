// What to do about a shot that does not count, or whose numbers are doubtful. Pure; thread-safe.
#pragma once

#include <string>

#include "host/session/shot.hpp"

namespace strobe::web {

/// A sentence or more; empty: there is nothing to be done.
std::string advice(const host::Shot& result);

}  // namespace strobe::web
