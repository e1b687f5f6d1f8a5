// What a person at the console sees and says of commissioning. Reads standard input, writes standard output and standard
// error; single-threaded; never waits.
#pragma once

#include <string>

#include "host/commission/commissioning.hpp"

namespace strobe::host {

class CommissionConsole final : public commission::CommissioningListener {
 public:
  explicit CommissionConsole(bool json) : json_(json) {}

  void on_prompt(const commission::StepView& step, const commission::Prompt& prompt) override;
  void on_waiting(const commission::StepView& step, const std::string& words, commission::Act act) override;
  void on_result(const commission::StepView& step) override;

  /// Takes what has been typed: answers, or more time for what is waited for. An end of the input ends it.
  void read(commission::Commissioning& commissioning);

 private:
  void heed(const std::string& line, commission::Commissioning& commissioning);

  bool json_;
  bool ended_ = false;  ///< the input
  std::string typed_;
};

/// "passed  lamp_a  lamp A flashes 12.1 ± 0.1 us after its pulse (rig file: 12.0)"
std::string result_line(const commission::StepResult& result);

/// One object: {"step","title","state","value","sd","unit","limit","words","advice","fault","figures"}
std::string result_json(const commission::StepView& step);

}  // namespace strobe::host
