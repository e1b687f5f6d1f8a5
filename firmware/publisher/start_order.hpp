// In which order strobed was started on a session folder: the machine's clock does not say, since it may have been
// set back, or begins anew where a board has none that runs on. Each start adds its boot id to the file `starts`.
// A line that a power cut tore is passed over. Not real-time; one thread's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>

#include "common/result.hpp"

namespace strobe::firmware {

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
