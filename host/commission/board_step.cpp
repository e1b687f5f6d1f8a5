#include "host/commission/board_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <future>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "host/camera/calibration.hpp"
#include "host/commission/scale_check.hpp"
#include "host/commission/statistics.hpp"
#include "host/commission/steps.hpp"
#include "host/photographs/measure_photograph.hpp"

namespace strobe::commission {
namespace {

using camera::BoardView;

/// Of the board's neighbours: the length on it over that by the rig file's map, since a map of too many px a
/// metre makes lengths too short.
std::vector<Size> spacings_of(const BoardView& view, int width_px, int height_px,
                              const digitize::PlaneMap& map, double px_per_m) {
  double spacing_m = 1e9;
  for (std::size_t i = 1; i < view.board_m.size(); ++i)
    spacing_m = std::min(spacing_m, cv::norm(view.board_m[i] - view.board_m[0]));
  std::vector<Size> spacings;
  for (std::size_t i = 0; i < view.board_m.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double on_board_m = cv::norm(view.board_m[i] - view.board_m[k]);
      if (on_board_m > 1.01 * spacing_m) continue;
      const double by_map_m =
          cv::norm(map.to_plane(view.image_px[i]) - map.to_plane(view.image_px[k])) / px_per_m;
      const cv::Point2d middle = 0.5 * (view.image_px[i] + view.image_px[k]);
      spacings.push_back(
          {middle.x / width_px - 0.5, 0.5 - middle.y / height_px, -std::log(by_map_m / on_board_m)});
    }
  }
  return spacings;
}

namespace fs = std::filesystem;

constexpr Duration kLookEvery = std::chrono::milliseconds{500};
constexpr std::size_t kMinViews = 2;

camera::BoardPattern pattern_of(const host::CommissionTable& table) {
  return {camera::BoardKind::chessboard, table.board_columns, table.board_rows,
          1e-3 * table.board_spacing_mm};
}

class BoardStep final : public Step {
 public:
  BoardStep()
      : Step({{"board", "calibration against the printed board", {"camera", "commission"}}},
             {.operator_acts = true}) {}
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
  void add(Found found);
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

}  // namespace

double covered_share(std::span<const BoardView> views, int width_px, int height_px) {
  constexpr int kCells = 200;  // of either side: a board's edge is told to half a percent
  cv::Mat covered = cv::Mat::zeros(kCells, kCells, CV_8U);
  for (const BoardView& view : views) {
    std::vector<cv::Point> points, outline;
    for (const cv::Point2d& p : view.image_px)
      points.emplace_back(static_cast<int>(kCells * p.x / width_px),
                          static_cast<int>(kCells * p.y / height_px));
    cv::convexHull(points, outline);
    cv::fillConvexPoly(covered, outline, cv::Scalar(1));
  }
  return static_cast<double>(cv::countNonZero(covered)) / (kCells * kCells);
}

Result<BoardCheck> check_board(std::span<const BoardView> views, int width_px, int height_px,
                               const digitize::PlaneMap& map, double px_per_m) {
  camera::CalibrationSettings settings;
  settings.width_px = width_px;
  settings.height_px = height_px;
  const auto found = camera::calibrate(views, settings);
  if (!found) return tl::unexpected(found.error());
  BoardCheck check;
  check.views = static_cast<int>(views.size());
  check.covered = covered_share(views, width_px, height_px);
  check.residual_px = found->fit.sigma_px;
  const double freedom = 2.0 * found->fit.points - static_cast<double>(found->fit.parameters.size());
  check.residual_sd_px = check.residual_px / std::sqrt(2.0 * std::max(1.0, freedom));
  const auto [terms, covariance] =
      fit_plane(spacings_of(views.front(), width_px, height_px, map, px_per_m), 0.0);
  check.scale_off = std::expm1(terms[0]);
  check.across = terms[1], check.upwards = terms[2];
  check.scale_sd = std::sqrt(covariance(0, 0));
  check.across_sd = std::sqrt(covariance(1, 1)), check.upwards_sd = std::sqrt(covariance(2, 2));
  return check;
}

StepResult judge_board(const BoardCheck& check) {
  StepResult result = passed(
      100.0 * check.scale_off, 100.0 * check.scale_sd, "%",
      fmt::format("scale within {:.1f} %, slope within {:.1f} %, residuals below {:.1f} px, {:.0f} % of the "
                  "view covered",
                  100.0 * kMaxBoardScale, 100.0 * kMaxSlope, kMaxBoardResidual_px, 100.0 * kMinCovered));
  result.words = fmt::format(
      "by {} photographs of the board the rig file's scale is {:+.2f} % off, {:+.2f} % more from left to "
      "right, {:+.2f} % upwards; residuals of {:.2f} px, {:.0f} % of the view covered",
      check.views, 100.0 * check.scale_off, 100.0 * check.across, 100.0 * check.upwards, check.residual_px,
      100.0 * check.covered);
  result.figures = {{"scale_off_percent", 100.0 * check.scale_off, 100.0 * check.scale_sd, 0.0, check.views},
                    {"across_percent", 100.0 * check.across, 100.0 * check.across_sd, 0.0, check.views},
                    {"upwards_percent", 100.0 * check.upwards, 100.0 * check.upwards_sd, 0.0, check.views},
                    {"residual_px", check.residual_px, check.residual_sd_px, {}, check.views},
                    {"covered_percent", 100.0 * check.covered, {}, {}, check.views}};
  const char* const tell = "photograph the board again, in more places";
  hold(result, interval(check.residual_px, check.residual_sd_px), {.most = kMaxBoardResidual_px},
       "board_unclear",
       "focus, light the board evenly, see that it is flat and that spacing and corners are as stated", tell);
  hold(result, interval(check.covered, 0.0), {.least = kMinCovered}, "board_too_small",
       "photograph the board in more places, to the corners of the view, or print a larger one");
  hold(result, interval(check.scale_off, check.scale_sd), within(kMaxBoardScale), "scale_off",
       "calibrate again: strobe calibrate with these photographs and --rig", tell);
  for (const Interval& slope :
       {interval(check.across, check.across_sd), interval(check.upwards, check.upwards_sd)})
    hold(result, slope, within(kMaxSlope), "camera_tilted",
         "the camera has moved since its calibration: strobe calibrate with these photographs and --rig",
         tell);
  return result;
}

std::string BoardStep::briefing(const host::RigFile& rig) const {
  return fmt::format(
      "Nothing moves. Photograph the board by room light into {}: first in the plane where balls fly, then "
      "slanted and in other places of the view; named so that the first sorts first.",
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

void BoardStep::add(Found found) {
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
    return Done{{skipped("the rig file names no photographs of a board",
                         "name board_folder and board_spacing_mm in [commission]; until then only the balls' "
                         "size and gravity check the scale")}};
  if (!looked_ || situation.now - *looked_ >= kLookEvery) {
    looked_ = situation.now;
    look(rig);
  }
  if (under_way_.valid()) {
    if (under_way_.wait_for(std::chrono::seconds{0}) == std::future_status::ready) add(under_way_.get());
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
        "no_board",
        problem_.empty() ? "no photograph of the board came into " + *rig.commission.board_folder : problem_,
        "the whole board must be in the view, with as many corners as stated");
  const auto settings = host::digitize_settings(rig, width_px_, height_px_);
  if (!settings)
    return failed("wrong_size", settings.error().message, "photograph the board as balls are photographed");
  if (!settings->px_per_m)
    return failed("no_scale", "the rig file has no scale",
                  "calibrate: strobe calibrate with these photographs and --rig");
  const auto check = check_board(views_, width_px_, height_px_, settings->map, *settings->px_per_m);
  if (!check)
    return failed("board_unclear", check.error().message, "photograph the board anew, flat and in focus");
  return judge_board(*check);
}

std::unique_ptr<Step> board_step() { return std::make_unique<BoardStep>(); }

}  // namespace strobe::commission
