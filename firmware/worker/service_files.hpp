// What the shipped unit gives strobed (strobed.service.in), for --check, which runs outside it.
#pragma once

#include "firmware/core/rig.hpp"
#include "firmware/worker/options.hpp"

namespace strobe::firmware {

inline constexpr const char* kServiceRigFile = "/etc/strobe/rig.toml";
inline constexpr const char* kServiceKeyFile =
    "/etc/strobe/lab.key";  ///< reaches the service as a credential
inline constexpr const char* kServiceSession = "/var/lib/strobe";

/// As the service will have it: with its rig file root checks its key and its session folder, unless options
/// or rig file name others. Root's own key in ~/.config is of no use to the service.
Options options_of_check(Options options, const Rig& rig, bool root);

/// What to say of a key that is not the service's although the rig file is; empty: nothing.
std::string key_note(const Options& options, const Rig& rig);

}  // namespace strobe::firmware
