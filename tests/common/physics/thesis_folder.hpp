// The thesis's data, loaded once for the tests.
#pragma once

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "common/data/thesis_data.hpp"

namespace strobe::testing {

inline const thesis::Data& thesis_data(thesis::Version version) {
  const auto load = [](thesis::Version v) {
    auto data = thesis::load(STROBE_THESIS_FOLDER, v);
    if (!data) throw std::runtime_error(data.error().message);
    return *std::move(data);
  };
  static const thesis::Data printed = load(thesis::Version::as_printed);
  static const thesis::Data corrected = load(thesis::Version::corrected);
  return version == thesis::Version::as_printed ? printed : corrected;
}

inline std::string thesis_file(const std::string& name) {
  std::ifstream file(std::string(STROBE_THESIS_FOLDER) + "/" + name, std::ios::binary);
  if (!file) throw std::runtime_error(name + " cannot be read");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace strobe::testing
