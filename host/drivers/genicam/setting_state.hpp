// What became of a setting, by what was read back. Pure; thread-safe.
#pragma once

#include <string>

#include "host/tether/driver_messages.hpp"

namespace strobe::genicam {

/// What a feature is.
enum class Kind { absent, enumeration, integer, number, boolean, text, command };

/// Whether two texts are the same value of such a feature.
bool is_same(Kind kind, const std::string& asked, const std::string& is);

/// How an asked value compares with what was read back. before: what the camera had; refusal: what it said,
/// empty if nothing.
tether::Setting judged(const std::string& name, Kind kind, const std::string& asked,
                       const std::string& before, const std::string& is, const std::string& refusal);

}  // namespace strobe::genicam
