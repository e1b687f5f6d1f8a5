// The photograph pipeline as rig file and command line want it. Reads files; allocates.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/photograph_pipeline.hpp"

namespace strobe::host {

struct PhotographOptions {
  std::string folder;               ///< empty: the rig file's camera.folder, if it names one
  std::string effort = "standard";  ///< as `strobe digitize` has it
};

/// Returns null if no folder is named. Fails with one line if the folder cannot be watched or the rig file
/// gives no scale. The pipeline's first notifications name the folder, and tell if the calibration is old.
/// keep_folder: the session's; empty: no photograph is copied.
Result<std::unique_ptr<PhotographPipeline>> open_pipeline(const RigFile& rig,
                                                          const PhotographOptions& options,
                                                          const std::filesystem::path& keep_folder,
                                                          std::int64_t host_id, const DeviceClock& clock,
                                                          const HostReading& now);

}  // namespace strobe::host
