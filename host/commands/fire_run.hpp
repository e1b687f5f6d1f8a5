// Fires a series: from LCM to the screen and the session folder. Single-threaded; blocks until the series is
// over or interrupted.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/data/thesis_data.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/shared_options.hpp"
#include "host/commands/terminal.hpp"
#include "host/commands/web_page.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/photograph_pipeline.hpp"
#include "host/series/wanted.hpp"
#include "host/session/run_lock.hpp"
#include "host/session/run_record.hpp"
#include "host/session/shot_series.hpp"

namespace strobe::host {

struct FireOptions {
  RigOptions paths;
  std::string session, plan_path, design_path, spacing, spin;
  std::vector<std::string> notes, until_known;
  std::string protocol;        ///< a name or a file; empty: none
  std::string protocol_text;   ///< its file's, which the session keeps
  int protocol_seed = 0;       ///< of the order of balls
  double drop_height_m = 0.0;  ///< of a protocol's drops, for which the plan is then made; 0: throws
  bool no_pause = false;       ///< between a protocol's blocks
  std::string heading;         ///< of the screen, beside rig and session
  std::optional<double> angle_deg;
  std::optional<int> shots, until, retries;
  double wait_s = 60.0;
  PhotographOptions photographs;
  WebOptions web;
  bool dry = false, json = false, plain = false, clear_fault = false, resume = false, all = false;
};

struct FireRequest {
  FireRequest(FireOptions given, const authentication::Key& lab_key)
      : options(std::move(given)), key(lab_key) {}

  FireOptions options;  ///< with the session and the LCM URL that were chosen
  HostReading asked;    ///< when the command was given
  authentication::Key key;
  RigFile rig;
  ShotSeriesSettings series;
  std::vector<Wanted> wanted;  ///< of --until-known; empty: not given
  std::vector<Shot> earlier;   ///< with it: the session's, oldest first
  std::string plan_text;
  std::string train_remark;     ///< told at the start, if any
  std::string rig_remark;       ///< which rig file was taken where none was named; else empty
  std::optional<RunLock> lock;  ///< of the session
  RunRecord run;                ///< for the session's runs.jsonl, but for what only the run knows
  std::optional<thesis::Condition> condition;
  Terminal::Style style = Terminal::Style::plain;
};

/// Returns the exit status.
int run_fire(const FireRequest& request);

}  // namespace strobe::host
