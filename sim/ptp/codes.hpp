// Numbers of the Picture Transfer Protocol (ISO 15740:2013, clauses 5, 10 to 13) that the simulated camera
// knows, and of Nikon's extension (as libgphoto2's ptp.h names them) the properties by which a host sees what
// ruins a photograph.
#pragma once

#include <cstdint>
#include <vector>

namespace strobe::sim::ptp {

using Bytes = std::vector<std::uint8_t>;

enum class Operation : std::uint16_t {
  get_device_info = 0x1001,
  open_session = 0x1002,
  close_session = 0x1003,
  get_storage_ids = 0x1004,
  get_storage_info = 0x1005,
  get_num_objects = 0x1006,
  get_object_handles = 0x1007,
  get_object_info = 0x1008,
  get_object = 0x1009,
  delete_object = 0x100B,
  initiate_capture = 0x100E,
  get_property_description = 0x1014,
  get_property_value = 0x1015,
  set_property_value = 0x1016,
  get_partial_object = 0x101B,
};

enum class Response : std::uint16_t {
  ok = 0x2001,
  session_not_open = 0x2003,
  operation_not_supported = 0x2005,
  invalid_storage = 0x2008,
  invalid_object = 0x2009,
  property_not_supported = 0x200A,
  store_full = 0x200C,
  access_denied = 0x200F,
  device_busy = 0x2019,
  invalid_property_format = 0x201B,
  invalid_property_value = 0x201C,
  invalid_parameter = 0x201D,
  session_already_open = 0x201E,
};

enum class EventCode : std::uint16_t {
  object_added = 0x4002,
  property_changed = 0x4006,
  store_full = 0x400A,
  capture_complete = 0x400D,
};

enum class ObjectFormat : std::uint16_t {
  association = 0x3001,  ///< a folder
  exif_jpeg = 0x3801,
  png = 0x380B,
  tiff = 0x380D,
  dng = 0x3811,
};

enum class PropertyCode : std::uint16_t {
  battery_level = 0x5001,
  compression = 0x5004,
  f_number = 0x5007,
  focus_mode = 0x500A,
  exposure_time = 0x500D,
  exposure_program = 0x500E,
  exposure_index = 0x500F,
  date_time = 0x5011,
  nikon_monitor_off = 0xD064,
  nikon_long_exposure_noise_reduction = 0xD06B,
  nikon_image_review = 0xD165,
  nikon_iso_auto = 0xD16A,
};

constexpr std::uint16_t number(auto code) { return static_cast<std::uint16_t>(code); }

inline constexpr std::uint32_t kNikon = 0x0000000A;  ///< VendorExtensionID

}  // namespace strobe::sim::ptp
