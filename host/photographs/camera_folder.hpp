// The folder into which the camera, or the program that it is tethered to, puts photographs: what has newly
// arrived and is written to its end. Files that were there before are old and left alone. Told by the kernel
// (inotify), and by looking once a second, since network folders and full queues do not tell. Reads the file
// system; one thread's; never throws.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "host/photographs/left_photographs.hpp"
#include "host/tether/driver_messages.hpp"

namespace strobe::host {

struct Arrival {
  std::filesystem::path path;
  HostTime arrived;      ///< when it was renamed or closed, as noticed here
  HostTime written;      ///< the file's own time of its last change
  bool renamed = false;  ///< put there whole under its name: no writer changes it in place
  std::optional<tether::ExposureStart> exposed = {};  ///< as the camera's clock tells
  std::string lost = {};  ///< why there is no photograph of that exposure; empty: there is one
};

class CameraFolder {
 public:
  /// Fails if it is no folder that can be read.
  static Result<std::unique_ptr<CameraFolder>> open(const std::filesystem::path& folder, HostTime now);
  ~CameraFolder();
  CameraFolder(const CameraFolder&) = delete;
  CameraFolder& operator=(const CameraFolder&) = delete;

  /// What has arrived since; never waits. Hidden files and those ending in ~, .tmp, .temp, .part or .partial
  /// are not photographs yet.
  std::vector<Arrival> look(HostTime now);
  /// For a person: files of a kind that cannot be read, a folder that went away and came back.
  std::vector<std::string> take_notifications() { return std::exchange(notifications_, {}); }

  /// What was there when it was opened and has not changed since.
  std::vector<OldFile> old_files();

  /// Readable when look() may find something at once.
  int descriptor() const { return inotify_; }
  const std::filesystem::path& path() const { return folder_; }

 private:
  struct Identity {
    std::uint64_t inode = 0;
    std::int64_t size = 0;
    WallTime changed;
    bool operator==(const Identity&) const = default;
  };

  CameraFolder(std::filesystem::path folder, int inotify) : folder_(std::move(folder)), inotify_(inotify) {}
  bool watch();
  void take_events(HostTime now, std::vector<Arrival>& arrivals);
  void scan(HostTime now, std::vector<Arrival>& arrivals);
  void consider(const std::string& name, bool renamed, HostTime now, std::vector<Arrival>& arrivals);
  bool wanted(const std::string& name);
  bool identify(const std::string& name, Identity& identity) const;

  std::filesystem::path folder_;
  int inotify_ = -1;
  int watch_ = -1;
  bool rescan_ = false;
  HostTime scanned_;
  std::map<std::string, Identity> known_, old_;
  std::map<std::string, Identity> changing_;  ///< seen by looking; arrived once it stays the same
  std::set<std::string> said_kinds_;
  std::vector<std::string> notifications_;
};

}  // namespace strobe::host
