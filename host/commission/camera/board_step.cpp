#include "host/commission/camera/board_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "host/photographs/measure_photograph.hpp"

namespace strobe::commission {
namespace {

namespace fs = std::filesystem;

constexpr const char* kId = "board";
constexpr Duration kLookEvery = std::chrono::milliseconds{500};
constexpr std::size_t kMinViews = 2;

camera::BoardPattern pattern_of(const host::CommissionTable& table) {
  return {camera::BoardKind::chessboard, table.board_columns, table.board_rows,
          1e-3 * table.board_spacing_mm};
}

}  // namespace

const std::vector<StepInfo>& BoardStep::infos() const {
  static const std::vector<StepInfo> infos{
      {kId, "calibration against the printed board", {"camera", "commission"}}};
  return infos;
}

std::string BoardStep::briefing(const host::RigFile& rig) const {
  return fmt::format(
      "Nothing moves. Photograph the board by room light into {}: first in the plane where balls fly, then "
      "slanted and in "
      "other places of the view; named so that the first sorts first.",
      rig.commission.board_folder.value_or("the folder that board_folder in [commission] names"));
}

void BoardStep::begin(const Situation& situation) {
  begun_ = situation.now;
  looked_.reset();
  seen_.clear();
  waiting_.clear();
  under_way_ = {};
  views_.clear();
  problem_.clear();
}

void BoardStep::look(const host::RigFile& rig) {
  std::error_code error;
  std::vector<fs::path> fresh;
  for (const auto& entry : fs::directory_iterator(*rig.commission.board_folder, error))
    if (entry.is_regular_file(error) && seen_.insert(entry.path()).second) fresh.push_back(entry.path());
  std::ranges::sort(fresh);
  waiting_.insert(waiting_.end(), fresh.begin(), fresh.end());
}

void BoardStep::take(Found found) {
  if (!found.view) {
    problem_ = found.problem;
    return;
  }
  if (!views_.empty() && (found.width_px != width_px_ || found.height_px != height_px_)) {
    problem_ = found.view->name + ": another size than the first";
    return;
  }
  width_px_ = found.width_px, height_px_ = found.height_px;
  views_.push_back(std::move(*found.view));
}

Request BoardStep::step(const Situation& situation) {
  const host::RigFile& rig = situation.rig;
  if (!rig.commission.board_folder || rig.commission.board_spacing_mm <= 0.0)
    return Done{{skipped(
        kId, "the rig file names no photographs of a board",
        "name board_folder and board_spacing_mm in [commission]; until then only the balls' size and gravity "
        "check the scale")}};
  if (!looked_ || situation.now - *looked_ >= kLookEvery) {
    looked_ = situation.now;
    look(rig);
  }
  if (under_way_.valid()) {
    if (under_way_.wait_for(std::chrono::seconds{0}) == std::future_status::ready) take(under_way_.get());
  } else if (!waiting_.empty()) {
    under_way_ =
        std::async(std::launch::async, [file = waiting_.front(), pattern = pattern_of(rig.commission)] {
          Found found;
          const auto photograph = digitize::load_photograph(file);
          if (!photograph) {
            found.problem = photograph.error().message;
            return found;
          }
          auto view = camera::find_board(*photograph, pattern);
          if (view)
            found.view = std::move(*view);
          else
            found.problem = view.error().message;
          found.width_px = photograph->width(), found.height_px = photograph->height();
          return found;
        });
    waiting_.erase(waiting_.begin());
  }
  const bool idle = waiting_.empty() && !under_way_.valid();
  const double covered = views_.empty() ? 0.0 : covered_share(views_, width_px_, height_px_);
  const bool enough = views_.size() >= kMinViews && covered >= kMinCovered;
  if (idle && (enough || situation.now - begun_ > situation.patience)) return Done{{judge(rig)}};
  return Wait{
      fmt::format(
          "photographs of the board: {} found, {:.0f} % of the view covered; wanted are {} and {:.0f} %{}",
          views_.size(), 100.0 * covered, kMinViews, 100.0 * kMinCovered,
          problem_.empty() ? "" : " (" + problem_ + ")"),
      Act::none};
}

StepResult BoardStep::judge(const host::RigFile& rig) const {
  if (views_.empty())
    return failed(
        kId, "no_board",
        problem_.empty() ? "no photograph of the board came into " + *rig.commission.board_folder : problem_,
        "the whole board must be in the view, with as many corners as stated");
  const auto settings = host::digitize_settings(rig, width_px_, height_px_);
  if (!settings)
    return failed(kId, "wrong_size", settings.error().message,
                  "photograph the board as balls are photographed");
  if (!settings->px_per_m)
    return failed(kId, "no_scale", "the rig file has no scale",
                  "calibrate: strobe calibrate with these photographs and --rig");
  const auto check = check_board(views_, width_px_, height_px_, settings->map, *settings->px_per_m);
  if (!check)
    return failed(kId, "board_unclear", check.error().message,
                  "photograph the board anew, flat and in focus");
  return judge_board(kId, *check);
}

}  // namespace strobe::commission
