// The interface's fields as host/web/README.md lists them, to be held against the program's answers.
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>

namespace strobe::web_test {

/// The names in the first column of the table that follows a line that begins so.
inline std::set<std::string> documented_fields(const std::string& heading) {
  std::ifstream readme(STROBE_SOURCE_DIR "/host/web/README.md");
  std::set<std::string> fields;
  bool within = false;
  const std::regex name("`([a-z0-9_]+)`");
  for (std::string line; std::getline(readme, line);) {
    const bool row = line.starts_with("| `");
    if (within && !row && !fields.empty()) break;
    within = within || line.find(heading) == 0 || line.ends_with(heading);
    if (!within || !row) continue;
    const std::string first = line.substr(0, line.find('|', 1));
    for (std::sregex_iterator at(first.begin(), first.end(), name), end; at != end; ++at) fields.insert((*at)[1]);
  }
  return fields;
}

inline std::set<std::string> fields_of(const nlohmann::ordered_json& object) {
  std::set<std::string> fields;
  for (const auto& [name, value] : object.items()) fields.insert(name);
  return fields;
}

}  // namespace strobe::web_test
