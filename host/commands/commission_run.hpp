// Commissions a rig at a terminal: from LCM to the console, the page, the record and the session folder; and
// what a session keeps of a rig's record. Reads and writes files; single-threaded.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "common/result.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/web_page.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/photograph_pipeline.hpp"

namespace strobe::host {

struct CommissionRequest {
  RigOptions paths;
  RigFile rig;
  std::optional<authentication::Key> key;  ///< the lab's; always there for run_commission()
  std::string record_path, session;
  PhotographOptions photographs;
  WebOptions web;
  std::set<std::string> only;
  std::string from;
  std::map<std::string, std::string> skip;  ///< step: why
  double wait_s = 60.0;
  bool yes = false;
  bool json = false;
};

/// Blocks until all steps are over or it is interrupted. Returns the exit status.
int run_commission(const CommissionRequest& request);

/// Copies the rig file's record, if there is one, into the session's folder. rig_path: empty for the shipped
/// example, which is nobody's rig. Returns a sentence for the operator if the rig is not commissioned, or not
/// well; else empty. Fails with the file's name.
Result<std::string> keep_commission_record(const std::filesystem::path& rig_path, const RigFile& rig,
                                           const std::filesystem::path& session, WallTime now);

}  // namespace strobe::host
