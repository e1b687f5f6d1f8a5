#include "common/config/default_rig.hpp"

#include "common/config/files.hpp"

namespace strobe::config {

Result<std::string> rig_file_or_example(const std::string& given, const std::string& option) {
  if (!given.empty()) return given;
  const auto share = share_folder();
  if (!share) return fail("no " + option + " given, and " + share.error().message);
  return (*share / "rig.toml").string();
}

std::string example_remark(const std::string& given, const std::string& option) {
  const auto file = rig_file_or_example(given, option);
  return given.empty() && file ? "no " + option + " given: taking the example " + *file : "";
}

}  // namespace strobe::config
