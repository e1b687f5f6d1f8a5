// The journals of earlier starts in a session folder: what they hold, and what their ends left to mend. A
// torn end (the machine died, or the disk was full, in the middle of a write) is cut off, so that what
// follows in time is never taken for it; a shot without an end is named. A journal that another daemon is
// writing is left alone. At the start of the daemon, not real-time.
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
  std::int32_t last_shot_id = 0;      ///< largest in the folder; 0: none
  std::vector<EarlierBoot> earlier;   ///< with at least one event, newest first
  std::vector<std::string> repaired;  ///< what was mended or is lost, a line each; at most 160 characters
};

/// Reads all journals of the folder and mends them. What cannot be mended is named, too.
FolderFindings repair_journals(const std::filesystem::path& dir);

}  // namespace strobe::firmware
