// What strobed's command line asks for.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/authentication/key.hpp"

namespace strobe::firmware {

/// What --drill can let happen, to prove on the real rig that the outputs become safe.
inline constexpr std::array<std::string_view, 4> kDrills{"publisher-exception", "publisher-hang", "loop-hang",
                                                         "output-failure"};

struct Options {
  std::string config;
  std::filesystem::path session;
  std::string lcm_url;                     ///< resolved: command line, rig file, default
  std::string key_file;                    ///< --key-file; empty: not given
  std::optional<authentication::Key> key;  ///< of the lab; there whenever the worker runs
  std::string key_words;                   ///< the key's file and fingerprint
  bool allow_no_rt = false;
  bool verbose = false;
  bool json = false;
  std::string drill;      ///< one of kDrills; empty: none
  int drill_at_shot = 0;  ///< of this start, from 1, or the first later one that flashes; 0: none
};

}  // namespace strobe::firmware
