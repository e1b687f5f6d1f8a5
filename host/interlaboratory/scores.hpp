// How laboratories' results of one quantity agree: E_n numbers, z and zeta scores, the consensus of many by
// Algorithm A. Pure; thread-safe; allocates. Sources: ISO 13528:2015, 7.7, 9.4 to 9.7 and C.3.1; ISO/IEC
// 17043:2010, B.3 and B.4. Algorithm A as R's metRology::algA() states it, which was read; the standards were
// not.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace strobe::interlaboratory {

struct LaboratoryResult {
  std::string laboratory;
  double value = 0.0;
  double standard_uncertainty = 0.0;  ///< > 0
  double expanded_uncertainty = 0.0;  ///< > 0; half width of the 95 % interval
};

struct RobustMean {
  double mean = 0.0;
  double sd = 0.0;  ///< > 0
};

/// Huber's estimate of both, by Algorithm A iterated until neither moves by 1e-12 of the sd. Returns nullopt
/// with fewer than three values, where more than half of them are equal, and where it does not converge.
std::optional<RobustMean> robust_mean(std::span<const double> values);

enum class Performance { satisfactory, questionable, unsatisfactory };
/// |E_n| <= 1: satisfactory; else unsatisfactory.
Performance judge_en(double en);
/// |z| <= 2: satisfactory; >= 3: unsatisfactory. Also of z' and zeta.
Performance judge_z(double z);
std::string_view name(Performance performance);

struct Scores {
  std::optional<double> en;    ///< against a reference laboratory
  std::optional<double> z;     ///< z', where `with_uncertainty`
  std::optional<double> zeta;  ///< absent only for the reference itself
};

/// What all laboratories are held against.
struct AssignedValue {
  double value = 0.0;
  double standard_uncertainty = 0.0;
  double expanded_uncertainty = 0.0;
  std::string
      reference;  ///< the laboratory; empty: the consensus of all, whose uncertainty is 1.25 sd / sqrt(p)
};

struct Agreement {
  AssignedValue assigned;
  std::optional<double> assessment_sd;  ///< what z is in; absent: none is known
  bool with_uncertainty =
      false;                   ///< the assigned value's is above 0.3 of it and counts in z, which is z' then
  std::vector<Scores> scores;  ///< one for each result
};

struct Terms {
  std::string reference;  ///< a laboratory of the results; empty: of two the first, of more none
  std::optional<double> assessment_sd;  ///< > 0; absent: the robust sd of the others
};

/// results: at least two, of different laboratories. Returns nullopt where the reference is none of them, or
/// there is no consensus.
std::optional<Agreement> compare(std::span<const LaboratoryResult> results, const Terms& terms);

}  // namespace strobe::interlaboratory
