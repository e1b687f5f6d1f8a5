// A session as its folder holds it: runs of `strobe fire`, and every shot that they fired, with its photograph, its
// digitizations and its readout computed again. Plain values; thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/shot/shot_key.hpp"
#include "host/config/rig_file.hpp"
#include "host/session/run_record.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

/// One measurement of a shot's photograph.
struct Digitization {
  strobe_msgs::frame_t frame;  ///< without times, as on LCM
  bool by_hand = false;        ///< a person corrected it afterwards, or measured it all
  std::string utc;             ///< when, as in results.csv
  std::string who;             ///< of a correction: who made it; else empty
  /// In the session's folder: the file that holds it, and the corrections that made it; empty: the log holds it.
  std::filesystem::path file, corrections;
};

struct StoredShot {
  ShotKey key;
  /// What a person calls it, everywhere: its shot_id; where two boots of the session have the same id, the later boots'
  /// with their boot: "3/1f2e4d".
  std::string name;
  std::string utc;                                  ///< when its result came, as in results.csv
  std::optional<strobe_msgs::shot_t> summary;       ///< absent: the firmware ended during the shot
  std::vector<Digitization> digitizations;          ///< oldest first; the newest counts
  std::optional<std::filesystem::path> photograph;  ///< kept in the session
  std::shared_ptr<const RigFile> rig;               ///< as the run that fired it used it; never null
  ShotResult result;                                ///< of the newest digitization
};

struct StoredSession {
  std::filesystem::path folder;
  RigFile rig;                              ///< as used
  std::string plan_text;                    ///< likewise
  std::vector<std::filesystem::path> logs;  ///< those that were read, oldest first
  std::vector<RunRecord> runs;              ///< oldest first; of hosts without a record only utc and host_id
  std::vector<StoredShot> shots;            ///< as fired; dry ones are left out
  std::vector<std::string> remarks;         ///< what could not be read or is missing, a sentence each
  bool verified = false;                    ///< all is sealed with the lab's key
};

}  // namespace strobe::host
