// A camera by Aravis (0.8): its features by their names, as text. GigE Vision and USB3 Vision. Blocks for as
// long as the camera takes to answer, 2.5 s if it does not. One thread's.
#pragma once

#include <glib-object.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/drivers/genicam/setting_state.hpp"
#include "host/tether/driver_messages.hpp"

typedef struct _ArvCamera ArvCamera;
typedef struct _ArvDevice ArvDevice;
typedef struct _ArvGcNode ArvGcNode;

namespace strobe::genicam {

struct Unreference {
  void operator()(gpointer object) const { g_object_unref(object); }
};
template <typename Object>
using Owned = std::unique_ptr<Object, Unreference>;

struct Range {
  double min = 0.0, max = 0.0;
};

/// All that are found now; looks for a second.
std::vector<tether::CameraIdentity> list_cameras();

class Camera {
 public:
  /// address: of the network, also where broadcasts do not reach, or as list_cameras() has it. Takes control
  /// of the camera; fails where another program has it.
  static Result<std::unique_ptr<Camera>> open(const std::string& address);
  ~Camera();
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  ArvCamera* aravis() const { return camera_.get(); }
  const tether::CameraIdentity& identity() const { return identity_; }
  bool is_gige() const;

  /// absent also while the camera says that it is not available.
  Kind kind(const std::string& name) const;
  Result<std::string> get(const std::string& name) const;
  /// Numbers, names of an enumeration's entries, true or false, from text.
  Result<void> set(const std::string& name, const std::string& value);
  Result<void> execute(const std::string& command);
  /// Of an enumeration, those that are available.
  std::vector<std::string> entries(const std::string& name) const;
  /// Of a number. Returns nullopt where it tells none.
  std::optional<Range> range(const std::string& name) const;

  /// GigE Vision's registers (bootstrap). Returns nullopt if it does not answer.
  std::optional<std::uint32_t> read_register(std::uint32_t address) const;
  bool write_register(std::uint32_t address, std::uint32_t value);

  /// Set by a thread of Aravis once the camera has been lost.
  bool lost() const;
  /// Readable then.
  int lost_descriptor() const;

 private:
  struct Loss;
  explicit Camera(ArvCamera* camera);
  ArvDevice* device() const;
  ArvGcNode* node(const std::string& name) const;

  std::shared_ptr<Loss> loss_;
  Owned<ArvCamera> camera_;
  tether::CameraIdentity identity_;
};

}  // namespace strobe::genicam
