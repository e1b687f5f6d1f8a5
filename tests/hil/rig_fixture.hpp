// A simulated bench with the shipped programs on it: strobe-sim runs strobed on a chip of its own, strobe
// fires it. Everything is in a temporary folder and goes with the object. One thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/hil/line_changes.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::hil {

/// For what must come: only a failure waits so long, however busy the machine.
inline constexpr std::chrono::seconds kLongestWait{180};

struct RigFixtureOptions {
  std::string scene = "zero_23";                                 ///< a shipped scene
  std::string scene_addition;                                    ///< TOML put after it: faults, actions
  std::vector<std::pair<std::string, std::string>> scene_edits;  ///< texts replaced in it; each must be there
  /// The rig file that strobe-sim writes for the scene, not the shipped one; photographs go into its camera's folder.
  bool scene_rig = false;
  bool sequencer = false;  ///< the lines are on a flash sequencer; not with scene_rig
  /// Texts replaced in the rig file; each must be there.
  std::vector<std::pair<std::string, std::string>> rig_edits;
  std::uint64_t seed = 1;
  std::vector<std::string> strobed_options;
  std::vector<std::string> sim_options;
  std::string lcm_url;  ///< of another bench; empty: one of its own
  std::string shell;    ///< a script run instead of strobed itself, which it finds as "$@"
  std::map<std::string, std::string> environment;  ///< of strobe-sim and strobed, added to the test's own
  testing::Privileges rights = testing::Privileges::inherited;
};

/// A third of the flashes, among which the ball is in view for a tenth of the time: fewer that a busy or
/// frozen machine can make late. For RigFixtureOptions::rig_edits.
inline const std::vector<std::pair<std::string, std::string>> kShortExposure{
    {"shutter_open_ms = 500", "shutter_open_ms = 160"}, {"impact_at_ms = 250", "impact_at_ms = 80"}};
/// For RigFixtureOptions::sim_options where only programs in the rig's time do anything: no RawHost, no
/// hand at the lines.
inline const std::vector<std::string> kFastTime{"--time", "fast"};
/// In the machine's own time, shots that may be fired again where any but the last are to count. Such a machine makes one
/// in five late; where others compile beside it, one in two has been seen: a dozen in a row is then one in 4000.
inline constexpr int kRetriesInRealTime = 12;

/// A loop that was to turn within 50 ms is looked at closely after 100 ms and known to hang when its core was
/// seen to run for another 60; twice that and some, since looks are lost on a busy machine. Without real-time
/// priorities the guardian sees nothing of the core, and waits for 0.5 s and 0.1 s of looks. [ns]
std::int64_t hang_known_within();

/// A shipped program. $STROBE_HIL_STROBED: another build of strobed, such as one with the thread sanitizer.
std::filesystem::path program(const std::string& name);
std::filesystem::path share(const std::filesystem::path& name);  ///< a shipped data file

/// With it a program sees the simulated chip of this folder as a GPIO chip of the machine.
std::map<std::string, std::string> environment_of_chip(const std::filesystem::path& chip_dir);

/// `text` with every `from` replaced; std::runtime_error if there is none.
std::string replaced(std::string text, const std::string& from, const std::string& to);

class RigFixture {
 public:
  explicit RigFixture(const RigFixtureOptions& options = {});

  /// Waits until strobed says that it is ready; else the log says why not.
  bool ready();
  std::string log() const { return sim_.err(); }

  testing::Process& sim() { return sim_; }
  pid_t guardian() const;  ///< 0: none
  pid_t worker() const;    ///< 0: none

  const std::filesystem::path& folder() const { return folder_.path(); }
  std::filesystem::path session() const { return folder_ / "session"; }
  std::filesystem::path rig_file() const { return folder_ / "rig.toml"; }
  std::filesystem::path chip_dir() const { return folder_ / "chip"; }
  const std::string& lcm_url() const { return lcm_url_; }
  std::filesystem::path journal() const;  ///< newest journal in the session's folder

  /// A command of strobe with this bench's rig file; fire and live also with its network.
  testing::Command strobe(std::vector<std::string> words) const;
  testing::Command fire(int shots, int retries, const std::vector<std::string>& more = {}) const;
  /// A `strobe fire` that is to be refused, run again with a longer --wait until it gives up for `reason`: on a
  /// busy machine seconds may pass before firmware is heard. The last run.
  testing::CompletedProcess refused(const testing::Command& fire, const std::string& reason) const;
  /// on this bench's chip, beside its strobed
  testing::Command strobed(const std::vector<std::string>& words) const;
  void drive(const std::string& line_and_level) const;

  testing::Process start(const testing::Command& command) { return {command, folder_.path()}; }

  /// Ends strobed in order and returns what the chip recorded.
  LineChanges finish();
  /// What the chip recorded; strobed must have ended.
  LineChanges changes();
  std::vector<nlohmann::json> truths() const;

 private:
  testing::Command sim_command(const RigFixtureOptions& options) const;
  std::string rig_of_scene(const RigFixtureOptions& options) const;

  testing::TemporaryFolder folder_;
  std::string lcm_url_;
  testing::Process sim_;
};

/// The readouts among the whole lines that strobe has printed.
std::vector<nlohmann::json> readouts(const std::string& out);

/// The lines themselves, for comparisons to the byte.
std::string readout_lines(const std::string& out);

bool has_flag(const nlohmann::json& readout, const std::string& flag);

// Rigs whose shots are soon over, and what a host leaves of them.

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
