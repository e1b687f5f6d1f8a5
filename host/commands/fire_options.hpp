// The command line of `strobe fire`, and what becomes of it with --resume. Plain values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/commands/photograph_options.hpp"
#include "host/commands/web_page.hpp"
#include "host/session/run_record.hpp"

namespace strobe::host {

struct FireOptions {
  std::string rig_path, url, session, plan_path, spacing, spin, key_file;
  std::vector<std::string> notes;
  std::optional<double> angle_deg;
  std::optional<int> shots, until, retries;
  double wait_s = 60.0;
  PhotographOptions photographs;
  WebOptions web;
  bool dry = false, json = false, plain = false, clear_fault = false, resume = false, all = false;
  std::vector<std::string> command;  ///< as typed
};

/// --spin, --angle and --note. Fails, naming the option.
Result<reduction::Record> notes_of(const FireOptions& options);

/// The options with which the session's last run is gone on with: what it was asked for, and from the given ones how.
/// Reads the session's folder. Fails where there is no such run, and names a given option that contradicts it.
Result<FireOptions> resumed(const FireOptions& given);

}  // namespace strobe::host
