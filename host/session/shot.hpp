// A shot, under way or stored, and what became of it: its readout, or why it has none. Deterministic; no I/O;
// thread-safe; allocates. How its fields are named and printed: shot_table.hpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/reduction/uncertainty.hpp"
#include "common/reduction/witnesses.hpp"
#include "common/shot/shot_key.hpp"
#include "host/assembly/assemble.hpp"
#include "host/config/rig_file.hpp"
#include "host/session/train_report.hpp"

namespace strobe::host {

/// One measurement of a shot's photograph.
struct Digitization {
  strobe_msgs::frame_t frame;  ///< without times, as on LCM
  bool by_hand = false;        ///< a person corrected it afterwards, or measured it all
  std::string utc;             ///< when, as in results.csv; empty while the shot is under way
  std::string who;             ///< of a correction: who made it; else empty
  /// In the session's folder: the file that holds it, and the corrections that made it; empty: the log holds
  /// it.
  std::filesystem::path file, corrections;
};

/// One shot, done with.
struct Shot {
  std::int64_t boot_id = 0;  ///< start of the firmware that fired it
  std::int64_t host_id = 0;  ///< who fired it
  int shot_id = 0;
  /// What a person calls it, everywhere: its shot_id; where two boots of the session have the same id, the
  /// later boots' with their boot: "3/1f2e4d". Empty while it is under way.
  std::string name;
  std::string session;  ///< its folder's name where shots of several sessions are together; else empty
  std::string utc;      ///< when its result came, as in results.csv; empty while it is under way
  bool dry = false;
  reduction::Readout readout;  ///< without numbers for a dry shot
  TrainReport train;
  std::optional<std::string> rejected;              ///< why it does not count; absent: it counts
  std::string problem;                              ///< more words for a person; may be empty
  bool verified = true;                             ///< false: nothing proves that its messages are the lab's
  std::optional<strobe_msgs::shot_t> summary;       ///< absent: the firmware ended during the shot
  std::vector<Digitization> digitizations;          ///< oldest first; the newest counts
  std::optional<std::filesystem::path> photograph;  ///< kept in the session
  std::shared_ptr<const RigFile> rig;  ///< as the run that fired it used it; null while it is under way
  /// Of the readout, with the times of the flashes: if AssemblySettings asks for budgets, until there is one.
  std::optional<reduction::Frame> matched;
  reduction::Budget budget;  ///< of the readout's uncertainty; without sources: it was not made
  /// Of its photograph, made with the budget.
  std::optional<reduction::PhotographWitnesses> witnesses;
  /// How this computer's clock and the rig's stood to each other then, see ClockState.
  std::optional<double> clock_drift_ppm;
  /// What its scale and map came from, and its ball: shots with the same text share the errors of it. Empty:
  /// likewise, but balls that a note (ball_name) tells apart.
  std::string calibration, ball;
  std::string plan;         ///< of a shot in a series: its train in words
  std::string until_known;  ///< RunRecord::until_known of the run that fired it

  ShotKey key() const { return {boot_id, shot_id}; }
  /// "3", or "run1:3" where there are several sessions.
  std::string full_name() const {
    return (session.empty() ? "" : session + ":") + (name.empty() ? std::to_string(shot_id) : name);
  }
  /// Of the photograph, as it was measured last; null: it was not.
  const strobe_msgs::frame_t* frame() const {
    return digitizations.empty() ? nullptr : &digitizations.back().frame;
  }
};

/// The readout, or the train report of a dry shot; whose it is, why it does not count, and whether it is the
/// lab's.
nlohmann::ordered_json shot_json(const Shot& shot);

/// Of a shot with its photograph. more: flags that shot and photograph do not tell.
Shot measured_shot(const strobe_msgs::shot_t& shot, const strobe_msgs::frame_t& frame,
                   const reduction::FlagSet& more, const AssemblySettings& settings);

/// Of a shot without; more: flags, among them why. problem: for a person.
Shot unmeasured_shot(const strobe_msgs::shot_t& shot, const reduction::FlagSet& more, std::string problem);

Shot dry_shot(const strobe_msgs::shot_t& shot);

/// Of a shot that has no summary. host_id: who fired it. why: for a person.
Shot interrupted_shot(const ShotKey& key, std::int64_t host_id, bool dry, std::string why);

// Which readouts count in a series, and the flags in words. No I/O; thread-safe.

/// A flag as a sentence for a person.
std::string_view words(reduction::Flag flag);
/// Likewise, with the flashes that it is about: of those that show the ball, where these are known.
std::string words(reduction::Flag flag, const reduction::Readout& readout, const FlashFaults& faults);

/// What flags likely come from, as a sentence for a person.
std::string words(const reduction::LikelyCause& cause);

/// By how much numbers may differ from one plausible assignment of flashes to images to the next: twice the
/// standard deviation between the hypotheses, which of two equally likely ones is their difference.
struct MatchTolerance {
  double percent = 1.0;  ///< of the speed at touchdown, of the spin of a ball that rolls with it, of 1 (e,
                         ///< mu, the court pace's 100), of 1 rad, of the dwell's own time and distance, the
                         ///< latter a tenth of the ball at least
  double ball_diameter_m = 0.0651;
};

/// Why the shot does not count and is fired again, in words. Returns nullopt if it counts. A shot is rejected
/// when it was aborted, has no photograph or too few images of the ball, when a flash that shows the ball was
/// missing or double, when its flash times are not plausible, or when it is so uncertain which flashes made
/// the images that some number depends on it by more than the tolerance. A late flash does not reject it: its
/// own time is used.
std::optional<std::string> rejection_reason(const reduction::Readout& readout,
                                            const MatchTolerance& tolerance = {},
                                            const FlashFaults& faults = {});

}  // namespace strobe::host
