#include "tests/host/commands/shipped_programs.hpp"

#include <algorithm>
#include <cmath>

#include "tests/support/json_lines.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::chain {

int Run::complaints() const { return static_cast<int>(std::count(err.begin(), err.end(), '\n')); }

Run run_program(const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), std::string(STROBE_BUILD_DIR) + "/bin/" + program);
  testing::Command command;
  command.arguments = std::move(arguments);
  const testing::CompletedProcess finished = testing::run_process(command, std::chrono::seconds(60));
  return {finished.status ? finished.status->code : -1, finished.out, finished.err};
}

std::vector<nlohmann::json> photograph(const testing::TemporaryFolder& folder, const std::string& name,
                                       const std::string& scene, int shots, const std::string& more) {
  const std::string file = folder / (name + ".toml");
  testing::write_text(file, "inherits = \"" + scene +
                                "\"\n[camera]\npx_per_m = 1500\norigin_x_px = 560\norigin_y_px = 110\n" +
                                more);
  const Run made = run_program("strobe-sim", {"photograph", "--scene", file, "--shots", std::to_string(shots),
                                              "--seed", "11", "--out", folder / name, "--json"});
  CHECK_TEXT(made.code == 0, made.err.c_str());
  return testing::parse_json_lines(made.out);
}

double worst_velocity_mps(const nlohmann::json& readout, const nlohmann::json& truth) {
  double worst = 0.0;
  for (const char* name : {"vx_td_mps", "vy_td_mps", "vx_lo_mps", "vy_lo_mps"}) {
    if (!readout.at(name).is_number()) return INFINITY;
    worst = std::max(worst,
                     std::abs(readout.at(name).get<double>() - truth.at("readout").at(name).get<double>()));
  }
  return worst;
}

bool spins_are_right(const nlohmann::json& readout, const nlohmann::json& truth) {
  bool right = true;
  for (const char* name : {"omega_td_radps", "omega_lo_radps"}) {
    const auto expected = truth.at("readout").at(name).get<double>();
    right = right && readout.at(name).is_number() &&
            std::abs(readout.at(name).get<double>() - expected) < std::max(0.01 * std::abs(expected), 1.5);
  }
  return right;
}

}  // namespace strobe::chain
