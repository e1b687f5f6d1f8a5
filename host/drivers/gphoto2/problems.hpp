// What of a camera's state spoils photographs of flashes, and what mends it. Pure; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/drivers/gphoto2/config_tree.hpp"
#include "host/tether/driver_messages.hpp"

namespace strobe::gphoto2 {

struct CameraState {
  Config config;
  std::optional<std::uint64_t> free_bytes;
  bool exposure_by_line = true;
  std::int64_t now_s = 0;  ///< this machine's wall clock, since 1970
};

std::vector<tether::Problem> find_problems(const CameraState& state);

/// Whether the camera says that it writes RAW files; nullopt if it does not say what it writes.
struct WrittenFiles {
  bool raw = false, jpeg = false;
};
std::optional<WrittenFiles> written_files(const Config& config);

}  // namespace strobe::gphoto2
