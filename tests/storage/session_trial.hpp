// The trial of a session folder: a series of three shots in a folder that holds an earlier one.
#pragma once

#include <filesystem>

#include "tests/storage/trial.hpp"

namespace strobe::storage {

Verdict run_session(const std::filesystem::path& folder, const testing::DiskFault& fault);

}  // namespace strobe::storage
