// One picture in many kinds of files, made by make_references.py with other programs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/image/image_files.hpp"

namespace strobe::testing {

inline std::filesystem::path reference(const std::string& name) {
  return std::filesystem::path(STROBE_TEST_DATA "/images") / name;
}

inline std::vector<std::uint8_t> reference_bytes(const std::string& name) {
  std::ifstream file(reference(name), std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace strobe::testing
