// What the numbers of shots keep that are told before or while a series is fired: the coverage of one that ends as soon as
// its mean is known well enough, computed; the power of a comparison of as many shots as were told. Deterministic from the
// seed. Thread-safe; allocates.
#pragma once

#include <cstdint>
#include <vector>

namespace strobe::studies {

/// Of one wanted half width, in units of the scatter's sd.
struct SequentialCoverage {
  double half_width = 0.0;
  double known_shots = 0.0;  ///< that would do if the scatter were known, (1.96 / half_width)^2
  double mean_shots = 0.0;
  double ends_at_first = 0.0;  ///< share of series that end with kMinSequentialShots shots
  double coverage = 0.0;       ///< of the interval that is given
  double plain_coverage = 0.0; ///< of Student's, if series ended as soon as that is short enough
};

/// By recursion over the density of the sum of squares of the series that go on, which gains the square of a
/// normal number with each shot (H. Robbins, Sequential estimation of the mean of a normal population, 1959).
/// half_width: 0.17 (130 shots) to 3; numbers are good to 1e-4.
SequentialCoverage sequential_coverage(double half_width);

/// Two series of normal numbers of as many shots as were told.
struct PowerCase {
  double first_sd = 1.0, second_sd = 1.0;
  double shared_sd = 0.0;  ///< of the difference
  double difference = 1.0;
  double asked = 0.8;
  int shots = 0;          ///< told, of each
  double promised = 0.0;  ///< by so many: at least what was asked for, since shots are whole
  double found = 0.0;     ///< share of pairs in which compare() decides
};
std::vector<PowerCase> run_power(int pairs, std::uint64_t seed);

}  // namespace strobe::studies
