// The rig file that a program takes when none is named: one rule for all of them. Reads the environment and
// /proc; call it from one thread.
#pragma once

#include <string>

#include "common/result.hpp"

namespace strobe::config {

/// `given`, or where it is empty the example in share_folder(), rig.toml. The example names lines that only a
/// chip labelled like it has (the simulated one), never offsets, so that it drives nothing elsewhere. Fails
/// if the folder does not exist; `option` is what would have named a file.
Result<std::string> rig_file_or_example(const std::string& given, const std::string& option);

/// "no --rig given: taking the example FILE", for who starts the program without one; empty if a file was
/// given.
std::string example_remark(const std::string& given, const std::string& option);

}  // namespace strobe::config
