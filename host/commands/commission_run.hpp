// Commissions a rig at a terminal: from LCM to the console, the record and the session folder. Single-threaded; blocks until
// all steps are over or it is interrupted.
#pragma once

#include <map>
#include <set>
#include <string>

#include "common/authentication/key.hpp"
#include "host/commands/web_page.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/photograph_pipeline.hpp"

namespace strobe::host {

struct CommissionRequest {
  explicit CommissionRequest(const authentication::Key& lab_key) : key(lab_key) {}

  authentication::Key key;
  RigFile rig;
  std::string rig_path, record_path, url, session;
  std::string key_file;  ///< as of --key-file
  PhotographOptions photographs;
  WebOptions web;
  std::set<std::string> only;
  std::string from;
  std::map<std::string, std::string> skip;  ///< step: why
  double wait_s = 60.0;
  bool yes = false;
  bool json = false;
};

/// Returns the exit status.
int run_commission(const CommissionRequest& request);

}  // namespace strobe::host
