// Runs of the shipped programs from photograph to readout, on sensors small enough to be quick. One thread.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::chain {

/// Of the photographs made here: a ball is 98 px wide.
inline constexpr double kPxPerM = 1500.0;

/// A run's end; the exit status is -1 where it did not end by itself.
struct Run {
  int code = -1;
  std::string out, err;
  int complaints() const;  ///< lines on standard error
};

/// `strobe-sim` or `strobe` with its arguments.
Run run_program(const std::string& program, std::vector<std::string> arguments);

/// Writes photographs of a shipped scene on the small sensor, with `more` added to its camera's table, to
/// folder/name, and gives the lines of truth. Fails the test if that cannot be.
std::vector<nlohmann::json> photograph(const testing::TemporaryFolder& folder, const std::string& name,
                                       const std::string& scene, int shots, const std::string& more = "");

/// The largest difference of a readout's four velocity components from the truth's. [m/s]
double worst_velocity_mps(const nlohmann::json& readout, const nlohmann::json& truth);

/// Whether both spins are within 1 % or 1.5 rad/s.
bool spins_are_right(const nlohmann::json& readout, const nlohmann::json& truth);

}  // namespace strobe::chain
