// The thesis's inputs, loaded once for the tests.
#pragma once

#include <stdexcept>

#include "host/thesis/thesis_inputs.hpp"

namespace strobe::testing {

inline report::ThesisInputs load_thesis(thesis::Version version, const std::string& set = {}) {
  auto inputs = report::load_inputs(STROBE_THESIS_FOLDER, version, set);
  if (!inputs) throw std::runtime_error(inputs.error().message);
  return *std::move(inputs);
}

inline const report::ThesisInputs& loaded_thesis(thesis::Version version) {
  static const report::ThesisInputs printed = load_thesis(thesis::Version::as_printed);
  static const report::ThesisInputs corrected = load_thesis(thesis::Version::corrected);
  return version == thesis::Version::as_printed ? printed : corrected;
}

}  // namespace strobe::testing
