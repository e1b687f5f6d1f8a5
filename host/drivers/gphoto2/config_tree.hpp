// A camera's configuration as libgphoto2 shows it: a tree of widgets, of which only the names, values and
// choices matter here. Values as text: a switch is 0 or 1, a time of day in seconds since 1970. Not
// thread-safe; a call may take seconds.
#pragma once

#include <gphoto2/gphoto2-camera.h>

#include <map>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace strobe::gphoto2 {

struct ConfigValue {
  std::string value;
  std::vector<std::string> choices;  ///< empty: any
  bool read_only = false;
};
/// By name; of two of one name the first.
using Config = std::map<std::string, ConfigValue>;

/// Of ASCII: makers write Bulb, bulb and BULB.
std::string lower_case(std::string text);

/// Empty where the camera has none. Fails with libgphoto2's words.
Result<Config> read_config(Camera* camera, GPContext* context);
/// Fails with libgphoto2's words, also if there is no setting of that name.
Result<void> set_config(Camera* camera, GPContext* context, const std::string& name,
                        const std::string& value);

}  // namespace strobe::gphoto2
