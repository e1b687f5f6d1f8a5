// Rigs whose shots are soon over, and what a host leaves of them.
#pragma once

#include <filesystem>

#include "tests/hil/rig_fixture.hpp"

namespace strobe::hil {

inline RigFixtureOptions short_shots() {
  RigFixtureOptions options;
  options.rig_edits = kShortExposure;
  return options;
}

/// With photographs written into a folder, of a ball of 98 px: quick to render and to measure.
inline RigFixtureOptions with_small_photographs(RigFixtureOptions options,
                                                const std::filesystem::path& folder) {
  options.scene_addition = "[camera]\npx_per_m = 1500\norigin_x_px = 600\norigin_y_px = 150\n";
  options.rig_edits.emplace_back("photograph_timeout_s = 5", "photograph_timeout_s = 60");
  options.rig_edits.emplace_back("\npx_per_m = 4000.0", "\npx_per_m = 1500\npx_per_m_sd = 0.5");
  options.sim_options = {"--photographs", folder};
  return options;
}

/// The host's log in a session's folder; empty if there is none.
inline std::filesystem::path host_log(const std::filesystem::path& session) {
  for (const auto& entry : std::filesystem::directory_iterator(session))
    if (entry.path().filename().string().starts_with("host-") && entry.path().extension() == ".lcmlog")
      return entry.path();
  return {};
}

}  // namespace strobe::hil
