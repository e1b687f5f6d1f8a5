#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "sim/commands.hpp"
#include "sim/rig/fit.hpp"

namespace strobe::sim {

int fit_command(const std::string& tables, const std::string& folder) {
  const auto complain = [](const std::string& message, int status) {
    fmt::print(stderr, "strobe-sim: {}\n", message);
    return status;
  };
  const auto data = thesis::load(tables, thesis::Version::corrected);
  if (!data) return complain(data.error().message, 2);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (const thesis::Condition& condition : data->conditions) {
    const auto fitted = fit_scene(condition);
    if (!fitted) return complain(fitted.error().message, 1);
    const std::filesystem::path path = std::filesystem::path(folder) / (condition.name() + ".toml");
    std::ofstream file(path);
    file << to_toml(*fitted, condition);
    file.flush();
    if (!file) return complain(path.string() + ": cannot be written", 2);
    for (const MissedSpread& miss : fitted->missed)
      fmt::print("{}: {}: published sd {:.3g}, here {:.3g}\n", condition.name(),
                 reduction::name(miss.quantity), miss.published_sd, miss.expected_sd);
  }
  return 0;
}

}  // namespace strobe::sim
