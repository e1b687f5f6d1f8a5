// The data of `strobe fit`: the thesis's conditions, or the shots of sessions' results.csv.
// Reads files; thread-safe; allocates.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/impact/fit/observation.hpp"
#include "common/result.hpp"

namespace strobe::host {

struct FitData {
  std::vector<impact::Observation> observations;
  int rejected = 0;    ///< shots marked rejected
  int incomplete = 0;  ///< shots left out since a velocity, spin or e is missing or the spin may be aliased
  std::vector<std::string>
      impossible;  ///< "SOURCE: shot 7: what no impact can have", of shots left out for it
  std::vector<std::string>
      repeated;  ///< "SOURCE: shot 7: how many have the same numbers", of shots that count once
};

/// The shipped conditions of the thesis.
Result<FitData> conditions_to_fit(thesis::Version version, impact::Spread spread);

/// Parses the shots of a results.csv (host/session/shot_table.hpp), one observation each, named
/// "SOURCE: shot 7" after its column shot or shot_id, else "SOURCE:LINE". Columns are found by name:
/// vx_td_mps, vy_td_mps, omega_td_radps, vx_lo_mps, omega_lo_radps and e are required; their sd_ columns,
/// dwell_time_ms, rejected, flags, spin and angle_deg are optional. An sd that is missing is 0. A series is a
/// spin and an angle, or the file where they are not noted. Fails with "SOURCE:LINE: column: what is wrong".
Result<FitData> parse_results(std::string_view text, const std::string& source);
Result<FitData> read_results(const std::filesystem::path& path);

}  // namespace strobe::host
