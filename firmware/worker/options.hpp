// strobed's command line.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/authentication/key.hpp"
#include "common/units/time.hpp"

namespace strobe::firmware {

/// Failures that --drill provokes, to prove on the real rig that the outputs become safe.
inline constexpr std::array<std::string_view, 4> kDrills{"publisher-exception", "publisher-hang", "loop-hang",
                                                         "output-failure"};

struct Options {
  std::string config;
  std::filesystem::path session;
  std::string lcm_url;                     ///< resolved: command line, rig file, default
  std::string key_file;                    ///< --key-file; empty if not given
  std::optional<authentication::Key> key;  ///< the lab's; has a value whenever the worker runs
  std::string key_words;                   ///< the key's file and fingerprint
  bool allow_no_rt = false;
  bool verbose = false;
  bool json = false;
  Duration trial = milliseconds(10'000);  ///< of the machine, with --check; 0: none
  std::string drill;                      ///< one of kDrills; empty: none
  /// counted from 1 since this start; a shot without flashes delays it to the next; 0: none
  int drill_at_shot = 0;
};

}  // namespace strobe::firmware
