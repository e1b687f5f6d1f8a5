// The calibration against a printed board: photographs that a person puts into a folder, looked at as they come. Nothing
// moves. Single-threaded; boards are found on threads of their own, one at a time.
#pragma once

#include <filesystem>
#include <future>
#include <optional>
#include <set>
#include <vector>

#include "host/commission/camera/board_check.hpp"
#include "host/commission/core/step.hpp"

namespace strobe::commission {

class BoardStep final : public Step {
 public:
  const std::vector<StepInfo>& infos() const override;
  Needs needs() const override { return {.operator_acts = true}; }
  std::string briefing(const host::RigFile& rig) const override;
  void begin(const Situation& situation) override;
  Request step(const Situation& situation) override;

 private:
  struct Found {
    std::optional<camera::BoardView> view;
    int width_px = 0, height_px = 0;
    std::string problem;
  };
  void look(const host::RigFile& rig);
  void take(Found found);
  StepResult judge(const host::RigFile& rig) const;

  HostTime begun_;
  std::optional<HostTime> looked_;
  std::set<std::filesystem::path> seen_;
  std::vector<std::filesystem::path> waiting_;
  std::future<Found> under_way_;
  std::vector<camera::BoardView> views_;
  int width_px_ = 0, height_px_ = 0;
  std::string problem_;  ///< of the last photograph without a board
};

}  // namespace strobe::commission
