#include "firmware/worker/service_files.hpp"

namespace strobe::firmware {

Options options_of_check(Options options, const Rig& rig, bool root) {
  if (!root || options.config != kServiceRigFile) return options;
  if (options.key_file.empty() && rig.key_file.empty()) options.key_file = kServiceKeyFile;
  if (options.session.empty()) options.session = kServiceSession;
  return options;
}

std::string key_note(const Options& options, const Rig& rig) {
  if (options.config != kServiceRigFile || !options.key_file.empty() || !rig.key_file.empty()) return "";
  return std::string("; this user's: the service has ") + kServiceKeyFile + ", which root can check";
}

}  // namespace strobe::firmware
