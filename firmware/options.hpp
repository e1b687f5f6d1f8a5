// What strobed's command line asks for.
#pragma once

#include <filesystem>
#include <string>

namespace strobe::firmware {

struct Options {
  std::string config;
  std::filesystem::path session;
  std::string lcm_url;  ///< resolved: command line, rig file, default
  bool allow_no_rt = false;
  bool verbose = false;
  bool json = false;
  int throw_at_shot = 0;  ///< --drill publisher-exception@N; 0: none
};

}  // namespace strobe::firmware
