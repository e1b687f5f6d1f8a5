// A camera spoken to by a person: found, opened, one picture after the other, each event waited for. Tells on
// standard error what takes longer than two seconds. Starts a driver; waits; single-threaded.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/config/rig_file.hpp"
#include "host/external/program.hpp"
#include "host/photographs/camera_folder.hpp"
#include "host/tether/camera_driver.hpp"

namespace strobe::host {

struct FoundCamera {
  std::string kind;  ///< as in the rig file
  tether::CameraIdentity camera;
};

struct FoundCameras {
  std::vector<FoundCamera> cameras;
  std::vector<std::string> problems;  ///< of a kind: its driver is not installed, or failed
};

/// Of all kinds.
FoundCameras find_cameras();

/// Where photographs come from: a driver's camera, which is asked for each, or a folder, whose next file is
/// waited for. Each call fails with one line; "interrupted" once a person has asked for the end.
class PictureSource {
 public:
  /// As the rig file's [camera] says. A driver's camera is opened, checked and set.
  static Result<PictureSource> open(const RigFile& rig);

  /// Of a driver's camera; null: of a folder.
  const tether::OpenedEvent* opened() const { return opened_ ? &*opened_ : nullptr; }
  /// The folder that is watched, or the camera, for a person.
  std::string name() const;
  /// The next picture, which the camera exposes for so long at once. Whole; a driver's goes with this object.
  Result<std::filesystem::path> next(double exposure_s);

 private:
  PictureSource() = default;
  Result<std::filesystem::path> snapped(double exposure_s);
  Result<std::filesystem::path> arrived();

  std::unique_ptr<external::WorkFolder> work_;
  std::unique_ptr<tether::CameraDriver> driver_;
  std::optional<tether::OpenedEvent> opened_;
  std::unique_ptr<CameraFolder> folder_;
};

}  // namespace strobe::host
