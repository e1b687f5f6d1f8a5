// One photograph measured, for whoever asks: as it arrives, again from its session, or by itself.
// Deterministic; reads files; thread-safe; allocates.
#pragma once

#include <filesystem>
#include <strobe_msgs/shot_t.hpp>
#include <tl/expected.hpp>
#include <vector>

#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/digitize/corrections.hpp"
#include "host/digitize/digitize.hpp"
#include "host/photographs/photograph_reader.hpp"

namespace strobe::host {

// What the rig file says to the digitizer: the ball, the calibrated scale, the camera. Values; thread-safe.

/// For photographs of that size. Without a scale in the rig file there is none in the settings: it is found.
/// Fails with one line if the camera's photographs have another size.
Result<digitize::DigitizeSettings> digitize_settings(const RigFile& rig, int width_px, int height_px);

/// Digitizes, corrects, and adds what the camera's calibration leaves open. Fails with one line.
Result<digitize::Digitization> measure(const digitize::Photograph& photograph,
                                       const digitize::DigitizeSettings& settings,
                                       const std::vector<digitize::Correction>& corrections,
                                       const CameraTable& camera);

/// When the flashes of a shot were [s, ascending, from the first that was seen]; empty: their order is not
/// plausible.
std::vector<double> flash_times_s(const strobe_msgs::shot_t& shot);

/// How the photographs of a shot are measured.
struct MeasureSettings {
  digitize::Effort effort = digitize::Effort::standard;
  std::vector<double> flash_times_s;  ///< empty: not known
  std::vector<digitize::Correction> corrections;
};

struct MeasuredPhotograph {
  digitize::Photograph photograph;
  digitize::DigitizeSettings settings;
  digitize::Digitization found;
};

/// Fails with one line that names the file.
tl::expected<MeasuredPhotograph, UnreadPhotograph> measure_photograph(const std::filesystem::path& file,
                                                                      const RigFile& rig,
                                                                      const MeasureSettings& settings);

}  // namespace strobe::host
