// One camera by libgphoto2 (gphoto2-camera.h): opened at a port, its events, its card. Calls block, most for
// milliseconds, a file for as long as it takes to read; a camera that does not answer for libgphoto2's time
// limits, some seconds. Errors are libgphoto2's words. Not thread-safe.
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/drivers/gphoto2/config_tree.hpp"
#include "host/tether/driver_messages.hpp"

namespace strobe::gphoto2 {

/// On the camera.
struct CardFile {
  std::string folder, name;
  auto operator<=>(const CardFile&) const = default;
};

struct CameraEvent {
  enum class Kind {
    none,
    file_added,
    capture_complete,
    setting_changed,
    card_full,
    other,
    unsupported,  ///< this camera tells of nothing
  };
  Kind kind = Kind::none;
  CardFile file{};  ///< that was added
};

class GphotoCamera {
 public:
  /// What can be found on USB, without serial numbers: for those each would have to be opened.
  static Result<std::vector<tether::CameraIdentity>> list();
  /// address: a port of libgphoto2 (usb:001,004, ptpip:192.168.1.5, disk:DIR); empty: whatever is found. Of
  /// several the one with that serial number; fails if there is none, or several and no number.
  static Result<std::unique_ptr<GphotoCamera>> open(const std::string& address, const std::string& serial);
  ~GphotoCamera();
  GphotoCamera(const GphotoCamera&) = delete;
  GphotoCamera& operator=(const GphotoCamera&) = delete;

  const tether::CameraIdentity& identity() const { return identity_; }
  Result<Config> config() { return read_config(camera_, context_); }
  Result<void> set(const std::string& name, const std::string& value) {
    return set_config(camera_, context_, name, value);
  }
  /// True also while it is busy.
  bool answers();
  std::optional<std::uint64_t> free_bytes();

  Result<CameraEvent> wait_for_event(std::chrono::milliseconds longest);
  Result<CardFile> capture();

  /// Of the folders named as DCF has them (CIPA DC-009: 100NIKON) only those from `first_folder` on, and all
  /// others.
  Result<std::vector<CardFile>> files(const std::string& first_folder);
  /// The last of the folders named as DCF has them; empty: there is none.
  Result<std::string> last_folder();
  /// Not known: nullopt.
  std::optional<std::uint64_t> size(const CardFile& file);
  /// Over what has that name. flush: it is on the disk once this returns.
  Result<void> save(const CardFile& file, const std::filesystem::path& path, bool flush);
  Result<void> remove(const CardFile& file);

 private:
  GphotoCamera() = default;
  static Result<std::unique_ptr<GphotoCamera>> open_port(const std::string& address);
  void identify(const std::string& address);
  Result<std::vector<std::string>> folders();

  GPContext* context_ = nullptr;
  Camera* camera_ = nullptr;
  tether::CameraIdentity identity_;
};

}  // namespace strobe::gphoto2
