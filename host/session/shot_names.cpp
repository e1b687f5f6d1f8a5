#include "host/session/shot_names.hpp"

#include <fmt/format.h>

#include <set>

namespace strobe::host {

std::vector<std::string> shot_names(const std::vector<ShotKey>& shots) {
  constexpr std::size_t kDigits = 6;
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (const ShotKey& key : shots) {
    const std::string boot = fmt::format("{:016x}", static_cast<std::uint64_t>(key.boot_id));
    std::string name = std::to_string(key.shot_id);
    for (std::size_t digits = kDigits; !taken.insert(name).second && digits <= boot.size(); ++digits)
      name = fmt::format("{}/{}", key.shot_id, boot.substr(0, digits));
    names.push_back(name);
  }
  return names;
}

}  // namespace strobe::host
