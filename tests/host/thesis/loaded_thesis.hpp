// The thesis's inputs, loaded once for the tests.
#pragma once

#include <stdexcept>

#include "host/thesis/thesis_inputs.hpp"

namespace strobe::testing {

inline thesis::ThesisInputs load_thesis(thesis::Version version, const std::string& set = {}) {
  auto inputs = thesis::load_inputs(STROBE_THESIS_FOLDER, version, set);
  if (!inputs) throw std::runtime_error(inputs.error().message);
  return *std::move(inputs);
}

inline const thesis::ThesisInputs& loaded_thesis(thesis::Version version) {
  static const thesis::ThesisInputs printed = load_thesis(thesis::Version::as_printed);
  static const thesis::ThesisInputs corrected = load_thesis(thesis::Version::corrected);
  return version == thesis::Version::as_printed ? printed : corrected;
}

}  // namespace strobe::testing
