// The fuzzing entry points that are linked into one program, which CMakeLists.txt lists.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace strobe::fuzz {

using EntryPoint = int (*)(const std::uint8_t* data, std::size_t size);

extern const std::map<std::string, EntryPoint> kEntryPoints;

}  // namespace strobe::fuzz
