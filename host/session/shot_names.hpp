// What a person calls the shots of a session. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <vector>

#include "common/shot/shot_key.hpp"

namespace strobe::host {

/// A name for each, in their order: the shot's number; where an earlier one has that, with as many hexadecimal digits of
/// its boot as tell it apart, six or more: "3/1f2e4d".
std::vector<std::string> shot_names(const std::vector<ShotKey>& shots);

}  // namespace strobe::host
