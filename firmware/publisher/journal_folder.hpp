// The journals of earlier starts in a session folder: looks at their ends and repairs them. A torn record at
// the end (power or disk space ran out during a write) is cut off; a shot without an end is reported. A
// journal that another daemon is writing is left alone. Only ends are read, so that a start takes as long
// whatever the journals' sizes. At the daemon's start, not real-time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace strobe::firmware {

struct EarlierBoot {
  std::int64_t boot_id = 0;
  std::int64_t last_sequence = 0;  ///< of the newest event in its journal

  bool operator==(const EarlierBoot&) const = default;
};

struct FolderFindings {
  /// So many of the newest are repaired and listed; older ones were so when they were new.
  static constexpr std::size_t kLatest = 16;

  /// Highest in the folder's journals, or, where numbers are set aside on the disk, in the latest ones; 0:
  /// none.
  std::int32_t last_shot_id = 0;
  std::vector<EarlierBoot> earlier;   ///< with at least one event, newest first
  std::vector<std::string> repaired;  ///< what was repaired or is lost, a line each of at most 160 characters
  /// The newest boot, if more than its journal's end remains to be looked through for damage.
  std::optional<std::int64_t> unchecked_boot;
};

/// Reads the last 64 KiB of the latest journals; more, up to 16 MiB, only where these hold no event. Without
/// a file of shots' numbers (shot_numbers.hpp) older ones, too, are read like this, as far as their last
/// shot. Repairs the latest ones; also reports what cannot be repaired.
FolderFindings repair_journals(const std::filesystem::path& dir);

/// In which order strobed was started on a session folder: the machine's clock does not say, since it may
/// have been set back, or begins anew where a board has none that runs on. Each start adds its boot id to the
/// file `starts`. A line that a power cut tore is passed over. Not real-time; one thread's.
class StartOrder {
 public:
  /// Of the file's last 64 KiB: nearly four thousand starts.
  explicit StartOrder(const std::filesystem::path& dir);
  /// The later the start, the larger; 0: not listed, and before all that are.
  std::size_t position(std::int64_t boot_id) const;

  /// On the disk when it returns. Fails with the path and the cause.
  static Result<void> add(const std::filesystem::path& dir, std::int64_t boot_id);

 private:
  std::map<std::int64_t, std::size_t> positions_;
};

}  // namespace strobe::firmware
