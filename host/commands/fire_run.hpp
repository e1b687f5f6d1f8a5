// The firing of a series from LCM to the screen. One thread's; blocks until done or interrupted.
#pragma once

#include <optional>
#include <string>

#include "common/authentication/key.hpp"
#include "common/data/thesis_data.hpp"
#include "host/commands/terminal.hpp"
#include "host/commands/watched_photographs.hpp"
#include "host/config/rig_file.hpp"
#include "host/session/session_folder.hpp"
#include "host/session/shot_series.hpp"

namespace strobe::host {

struct FireOrder {
  explicit FireOrder(const authentication::Key& lab_key) : key(lab_key) {}

  authentication::Key key;
  RigFile rig;
  ShotSeriesSettings series;
  std::string plan_text;
  std::string url;
  std::string session;
  PhotographOptions photographs;
  std::optional<thesis::Condition> condition;
  Terminal::Style style = Terminal::Style::plain;
};

/// Returns the exit status.
int run_fire(const FireOrder& order);

}  // namespace strobe::host
