// The digitizer on rendered photographs, held against the truth. Each study prints; some use several threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "host/digitize/core/types.hpp"
#include "sim/scene/scene.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::studies::digitize {

/// What may be asked of the studies; not each heeds all. Empty paths: no such file or folder.
struct Options {
  std::vector<std::string>
      scenes;  ///< empty: the thesis's conditions (chain: and the court-pace scene; robustness:
               ///< three of them)
  std::vector<std::string> axes;  ///< of the robustness; empty: all
  std::optional<int> shots;       ///< of each scene (robustness: at each point; latency: in all)
  int first_shot = 1;
  std::uint64_t seed = 1;
  strobe::digitize::Effort effort = strobe::digitize::Effort::standard;
  int rounds = 2;                  ///< the least of their times counts
  int jobs = 1;                    ///< photographs at a time; with more than one, times are not reported
  bool independent = false;        ///< photographs by the second renderer
  std::string ball;                ///< of the accuracy and the chain: scene whose ball it is; empty: the scenes'
  bool draw_line = false;          ///< a line on that ball, whatever its scene says
  bool ignore_marking = false;     ///< of the accuracy: Take::ignore_marking
  double scale_sd_percent = 0.05;  ///< of the chain's calibrated scale
  double ball_sd_mm = 0.0;         ///< by how much the chain's ball differs from what the rig file says
  std::vector<Duration>
      train;  ///< of the matches, as commanded, from the first flash; empty: even, as long as needed
  double issue_jitter_us = 0.0;             ///< by how much its flashes are issued late
  std::optional<double> flash_time_sd_us;   ///< of the matches, as a rig file's; empty: its default
  std::optional<double> machine_lag_sd_ms;  ///< likewise
  double noise = 1.0;  ///< of the RAW study's sensors, over the scenes'
  bool simulated = false;  ///< of the matches: nothing is rendered, the digitizer is a normal error
  bool viewpoint = true;   ///< of the matches: the lens's place is known, as from a calibration
  std::string save;        ///< folder for what went wrong
  std::string keep;        ///< Take::kept_in
  std::string csv;         ///< one line an image; of the robustness: a condition
};

/// The named scenes, or the thesis's conditions.
Result<std::vector<std::string>> scene_names(const std::vector<std::string>& named);
Result<std::vector<sim::Scene>> load_scenes(const std::vector<std::string>& names);

/// The scenes that are asked for, with options.ball in place of their own ball: with its look, its flight and the
/// light that it needs, the view, dwell time and spin such that images lie on the photograph as the tennis ball's.
Result<std::vector<sim::Scene>> scenes_of(const Options& options, const std::vector<std::string>& names);

/// Flashes as far apart as that takes.
sim::ShootSettings shooting_of(const Options& options, const sim::Scene& scene);

/// Accuracy condition by condition.
Result<void> study_accuracy(const Options& options);

/// The whole way from a shot to its readout: digitizer, match of images to flashes, best estimator; and what each
/// measurement contributes to the error.
Result<void> study_chain(const Options& options);

/// Shots of which flash made which image is in doubt, what is rejected, and normalized errors.
Result<void> study_matches(const Options& options);

/// From the rename of a photograph into the camera's folder to its shot's readout, through what `strobe live` runs.
/// Writes files into a temporary folder.
Result<void> study_latency(const Options& options);

/// Photographs by a colour sensor, as its mosaic and demosaiced, beside those of a grey one with the noise of the same
/// photosites. Needs dcraw_emu.
Result<void> study_raw(const Options& options);

/// How far conditions may go until the digitizer breaks, one at a time, and whether it then says so.
Result<void> study_robustness(const Options& options);

}  // namespace strobe::studies::digitize
