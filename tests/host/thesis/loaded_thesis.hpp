// The thesis's material, loaded once for the tests.
#pragma once

#include <stdexcept>

#include "host/thesis/thesis_inputs.hpp"

namespace strobe::testing {

inline report::Material load_thesis(thesis::Version version, const std::string& set = {}) {
  auto material = report::load_material(STROBE_THESIS_FOLDER, version, set);
  if (!material) throw std::runtime_error(material.error().message);
  return *std::move(material);
}

inline const report::Material& thesis_material(thesis::Version version) {
  static const report::Material printed = load_thesis(thesis::Version::as_printed);
  static const report::Material corrected = load_thesis(thesis::Version::corrected);
  return version == thesis::Version::as_printed ? printed : corrected;
}

}  // namespace strobe::testing
