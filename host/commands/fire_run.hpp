// Fires a series: from LCM to the screen and the session folder. Single-threaded; blocks until the series is
// over or interrupted.
#pragma once

#include <optional>
#include <string>

#include "common/authentication/key.hpp"
#include "common/data/thesis_data.hpp"
#include "host/clock/clock_reading.hpp"
#include "host/commands/terminal.hpp"
#include "host/commands/web_page.hpp"
#include "host/config/rig_file.hpp"
#include "host/photographs/photograph_pipeline.hpp"
#include "host/session/run_lock.hpp"
#include "host/session/run_record.hpp"
#include "host/session/shot_series.hpp"

namespace strobe::host {

struct FireRequest {
  explicit FireRequest(const authentication::Key& lab_key) : key(lab_key) {}

  HostReading asked;  ///< when the command was given
  authentication::Key key;
  RigFile rig;
  ShotSeriesSettings series;
  std::string plan_text;
  std::string train_remark;  ///< told at the start, if any
  std::string rig_remark;    ///< which rig file was taken where none was named; else empty
  std::string url;
  std::string session;
  std::optional<RunLock> lock;  ///< of the session
  PhotographOptions photographs;
  RunRecord run;  ///< for the session's runs.jsonl, but for what only the run knows
  std::optional<thesis::Condition> condition;
  Terminal::Style style = Terminal::Style::plain;
  bool all = false;  ///< show experts' numbers as well
  WebOptions web;
  std::string key_file;  ///< as of --key-file
};

/// Returns the exit status.
int run_fire(const FireRequest& request);

}  // namespace strobe::host
