// The journals of earlier starts in a session folder: reads and repairs them. A torn record at the end (power
// or disk space ran out during a write) is cut off; a shot without an end is reported. A journal that another
// daemon is writing is left alone. At the daemon's start, not real-time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace strobe::firmware {

struct EarlierBoot {
  std::int64_t boot_id = 0;
  std::int64_t last_sequence = 0;  ///< of the newest event in its journal

  bool operator==(const EarlierBoot&) const = default;
};

struct FolderFindings {
  std::int32_t last_shot_id = 0;      ///< highest in the folder; 0 if there is none
  std::vector<EarlierBoot> earlier;   ///< with at least one event, newest first
  std::vector<std::string> repaired;  ///< what was repaired or is lost, a line each of at most 160 characters
};

/// Reads all journals of the folder and repairs them; also reports what cannot be repaired.
FolderFindings repair_journals(const std::filesystem::path& dir);

}  // namespace strobe::firmware
