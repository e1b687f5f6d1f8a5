// A finder asked about every photograph, as it is and altered, told the right scale and wrong ones.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "tests/real/alterations.hpp"
#include "tests/real/finders.hpp"
#include "tests/real/judge.hpp"

namespace strobe::real {

struct Asked {
  std::vector<const Alteration*> alterations;
  std::vector<double> told{1.0};  ///< scales told, over the right one
  double tolerance_percent = 12.0;
  int jobs = 1;                                ///< photographs at once
  const std::atomic<bool>* stopped = nullptr;  ///< set by somebody else: no more photographs, and it fails
};

struct Outcome {
  const Photograph* photograph = nullptr;
  const Alteration* alteration = nullptr;
  double told = 1.0;
  Score score;
  std::vector<std::string> why;  ///< of each ball missed, what the program said of the place
};

/// In the order of alterations, photographs and scales. progress: how many photographs are done, from any
/// thread, one at a time. Fails with one line: a photograph that cannot be read or altered, or the finder's.
/// Reads files, writes into a temporary folder, runs threads.
Result<std::vector<Outcome>> evaluated(const std::vector<Photograph>& photographs, const Finder& finder,
                                       const Asked& asked,
                                       const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Of those outcomes with this alteration (nullptr: any) and told scale.
Score total(const std::vector<Outcome>& outcomes, const Alteration* alteration, double told = 1.0);

/// The one that does best on the photographs as they are, by Score::f1(). Fails as evaluated() does.
Result<NamedFinder> best_of(const std::vector<NamedFinder>& finders,
                            const std::vector<Photograph>& photographs, const Asked& asked);

}  // namespace strobe::real
