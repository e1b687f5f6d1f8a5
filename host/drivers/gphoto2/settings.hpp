// How a camera is set, by libgphoto2's names: what is asked of it and became of that, and what else matters
// for the record. Pure but for apply().
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/drivers/gphoto2/gphoto_camera.hpp"

namespace strobe::gphoto2 {

/// `asked` and, where the camera has them and it says nothing else, what photographs of flashes need: no
/// second exposure to take noise off the first, no automatic ISO, no picture review, no sleep, files onto the
/// card.
std::map<std::string, std::string> wanted_settings(const std::map<std::string, std::string>& asked,
                                                   const Config& config);

/// The camera's own word for what a person wrote: "5.6" is "f/5.6", "bulb" is "Bulb". What it has no word for
/// stays as it is.
std::string choice_for(const std::string& asked, const std::vector<std::string>& choices);

/// Sets them, one after another. By name: why the camera refused; the others it took, perhaps rounded.
std::map<std::string, std::string> apply(GphotoCamera& camera, const Config& before,
                                         const std::map<std::string, std::string>& wanted);

/// The setting of the exposure's length and its choice that is nearest to `exposure_s`, by ratio; empty: the
/// camera lets nobody choose.
struct TimeChoice {
  std::string name, value;
};
TimeChoice nearest_time(const Config& config, double exposure_s);

/// What was wanted, as read back in `after`, then what else matters.
std::vector<tether::Setting> settings_of(const Config& after,
                                         const std::map<std::string, std::string>& wanted,
                                         const std::map<std::string, std::string>& refused);

}  // namespace strobe::gphoto2
