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

/// By the extension.
inline Result<image::Raster> decoded(const std::string& name, const std::vector<std::uint8_t>& bytes) {
  const std::string kind = std::filesystem::path(name).extension().string();
  if (kind == ".tif") return image::decode_tiff(bytes);
  if (kind == ".png") return image::decode_png(bytes);
  if (kind == ".jpg") return image::decode_jpeg(bytes);
  if (kind == ".bmp") return image::decode_bmp(bytes);
  return image::decode_pnm(bytes);
}

}  // namespace strobe::testing
