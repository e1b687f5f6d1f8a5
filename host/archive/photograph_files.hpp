// The photographs that a session keeps, and which shot each shows. Reads a folder; thread-safe; allocates.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/shot/shot_key.hpp"

namespace strobe::host {

/// The number in photographs/shot-0007-NAME; absent: it is no such name.
std::optional<int> shot_number_in(const std::filesystem::path& photograph);

/// The file that a frame names, if it is one of the session's: "photographs/shot-0007-NAME".
std::optional<std::filesystem::path> named_photograph(const std::filesystem::path& session,
                                                      const std::string& name);

struct UnnamedPhotographs {
  std::map<ShotKey, std::filesystem::path> of_shot;
  std::vector<std::string> remarks;  ///< a sentence for each that cannot be told apart
};

/// Photographs that no frame names (`named`), by the number in their names, for those of `without` that have none. One
/// that may show either of two shots is used for neither.
UnnamedPhotographs unnamed_photographs(const std::filesystem::path& session,
                                       const std::set<std::filesystem::path>& named,
                                       const std::vector<ShotKey>& without);

}  // namespace strobe::host
