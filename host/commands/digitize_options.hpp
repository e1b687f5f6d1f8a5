// The options of `strobe digitize`. Single-threaded.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace strobe::host {

struct DigitizeOptions {
  std::vector<std::string> images;
  std::string rig;  ///< empty: none
  std::optional<double> px_per_m;
  std::optional<double> px_per_m_sd;
  std::optional<double> ball_diameter_m;
  std::optional<double> ball_diameter_sd_m;
  std::optional<double> size_tolerance_percent;
  std::optional<double> period_ms;
  std::string times_file;  ///< empty: none
  std::string effort = "standard";
  std::string direction = "auto";
  std::optional<int> bounce;  ///< from 1 in time
  std::string edit_file;      ///< empty: none
  std::string overlay;        ///< empty: none
  int shot_id = 1;            ///< of the first photograph
  bool json = false;
  bool explain = false;
};

void add_digitize_options(CLI::App& command, DigitizeOptions& options);

/// What of the options given does not go together, or an empty text.
std::string conflict(const DigitizeOptions& options);

}  // namespace strobe::host
