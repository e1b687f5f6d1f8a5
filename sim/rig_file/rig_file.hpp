// The rig file of a simulated rig: what strobed and the host have to know of a scene, as a person would write
// it after measuring the rig. Text only; pure; thread-safe.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

struct RigFileSettings {
  std::string rig_name = "bench";       ///< in the LCM channels
  std::string lcm_url{};                ///< empty: the default
  std::filesystem::path key_file{};     ///< of the lab; empty: where strobe looks for it
  std::filesystem::path photographs{};  ///< the camera's folder; empty: none, a person digitizes them
  /// As the host names them; an empty address: photographs come into the folder by themselves.
  std::filesystem::path sequencer{};  ///< its terminal; empty: the lines are the chip's
  std::string camera_kind{}, camera_address{}, camera_serial{};
};

/// Lines, delays, lags, ball, camera and plan of the scene, each with its unit and a remark. Where balls are
/// slow or fast the plan's period and exposure follow: about 51 mm between flashes, while they cross the
/// view. The same scene and settings give the same text; paths are written as they are given.
std::string rig_file_text(const Scene& scene, const RigFileSettings& settings);

/// Writes the text to `file`, and makes its folder and the photographs'; paths that lead into its folder are
/// written from there. A file that holds the same text stays; fails if there is another, or if it cannot be
/// written.
Result<void> write_rig_file(const std::filesystem::path& file, const Scene& scene, RigFileSettings settings);

}  // namespace strobe::sim
