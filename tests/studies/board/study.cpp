#include "tests/studies/board/study.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "host/camera/board_plan.hpp"
#include "sim/photograph/board.hpp"
#include "tests/studies/in_parallel.hpp"

namespace strobe::studies {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

struct Bench {
  sim::BoardCamera camera;
  sim::Board board;
  sim::BoardPlace plane;
};

/// A lens as is known of lenses; a board over a quarter to two thirds of the photograph's width.
Bench drawn_bench(Random& random) {
  std::normal_distribution<double> normal;
  Bench bench;
  bench.camera.width_px = 800;
  bench.camera.height_px = 640;
  const double diagonal_px = std::hypot(bench.camera.width_px, bench.camera.height_px);
  bench.camera.focal_px = diagonal_px * uniform(random, 1.2, 3.0);
  const double unit = bench.camera.focal_px / diagonal_px;
  const auto& sd = camera::kLensPriorSds;
  bench.camera.lens = {sd[0] * normal(random) * unit * unit, sd[1] * normal(random) * std::pow(unit, 4.0),
                       sd[2] * normal(random) * unit, sd[3] * normal(random) * unit};
  bench.camera.blur_px = uniform(random, 0.6, 1.2);
  bench.camera.noise = uniform(random, 0.005, 0.03);
  const double share = uniform(random, 0.25, 0.65);
  bench.board.spacing_m = share * bench.camera.width_px / bench.camera.focal_px / (bench.board.columns + 1);
  bench.plane.turns_deg = {2.0 * normal(random), 2.0 * normal(random), normal(random)};
  return bench;
}

bool is_seen_as_a_whole(const Bench& bench, const sim::BoardPlace& place) {
  const double s = bench.board.spacing_m, right = s * bench.board.columns, low = s * bench.board.rows;
  for (const cv::Point2d corner : {cv::Point2d(-s, -s), {right, -s}, {right, low}, {-s, low}}) {
    const cv::Point2d at = sim::image_of(bench.camera, bench.board, place, corner);
    if (!(at.x > 2.0 && at.y > 2.0 && at.x < bench.camera.width_px - 3.0 && at.y < bench.camera.height_px - 3.0))
      return false;
  }
  return true;
}

/// Where an operator holds it who knows of no plan.
sim::BoardPlace drawn_place(const Bench& bench, Random& random) {
  constexpr std::array<std::array<double, 2>, 4> kSlants{{{25, 0}, {-25, 0}, {0, 25}, {0, -25}}};
  for (;;) {
    sim::BoardPlace place;
    place.distance_m = uniform(random, 0.9, 1.4);
    const double half = 0.5 * bench.camera.width_px / bench.camera.focal_px;
    place.aside_m = {uniform(random, -half, half), uniform(random, -half, half)};
    const auto& slant = kSlants[std::uniform_int_distribution<std::size_t>(0, 3)(random)];
    place.turns_deg = {slant[0], slant[1], uniform(random, -5.0, 5.0)};
    if (is_seen_as_a_whole(bench, place)) return place;
  }
}

Result<camera::BoardView> photographed(const Bench& bench, const sim::BoardPlace& place, Random& random) {
  digitize::Photograph photograph;
  photograph.name = "board";
  sim::photograph_board(bench.camera, bench.board, place, random())
      .pixels.convertTo(photograph.intensity, CV_32F, 1.0 / 65535.0);
  return camera::find_board(photograph, {camera::BoardKind::chessboard, bench.board.columns, bench.board.rows,
                                         bench.board.spacing_m});
}

/// The operator goes by the outline: the board's middle and its size are where the plan has them.
sim::BoardPlace as_planned(const Bench& bench, const camera::PlannedBoard& planned, double px_per_m) {
  const double to_degrees = 180.0 / std::numbers::pi;
  const double z = bench.camera.focal_px / px_per_m * planned.placement.distance_share;
  const double slant = planned.placement.slant_rad * to_degrees;
  sim::BoardPlace place;
  place.distance_m = z;
  place.aside_m = {(planned.middle_px.x - 0.5 * (bench.camera.width_px - 1)) * z / bench.camera.focal_px,
                   (planned.middle_px.y - 0.5 * (bench.camera.height_px - 1)) * z / bench.camera.focal_px};
  switch (planned.placement.nearer) {
    case camera::NearerSide::left:
      place.turns_deg[1] = -slant;
      break;
    case camera::NearerSide::right:
      place.turns_deg[1] = slant;
      break;
    case camera::NearerSide::upper:
      place.turns_deg[0] = slant;
      break;
    case camera::NearerSide::lower:
      place.turns_deg[0] = -slant;
      break;
  }
  return place;
}

/// Image px per metre of the balls' plane, from how a small square there is mapped.
template <typename ToBoard>
double scale_at(const ToBoard& to_board, cv::Point2d at) {
  constexpr double kHalf_px = 0.05;
  const cv::Point2d along = to_board(at + cv::Point2d(kHalf_px, 0)) - to_board(at - cv::Point2d(kHalf_px, 0));
  const cv::Point2d down = to_board(at + cv::Point2d(0, kHalf_px)) - to_board(at - cv::Point2d(0, kHalf_px));
  return 2.0 * kHalf_px / std::sqrt(std::abs(along.cross(down)));
}

double rms_error(const Bench& bench, const camera::Calibration& found) {
  const auto map = found.map();
  double sum = 0.0;
  for (const double y : {0.1, 0.5, 0.9}) {
    for (const double x : {0.1, 0.5, 0.9}) {
      const cv::Point2d at(x * (bench.camera.width_px - 1), y * (bench.camera.height_px - 1));
      const double truth = scale_at(
          [&](cv::Point2d p) { return sim::board_at(bench.camera, bench.board, bench.plane, p); }, at);
      const double mapped =
          scale_at([&](cv::Point2d p) { return map.to_plane(p) * (1.0 / found.px_per_m); }, at);
      sum += std::pow(std::log(mapped / truth), 2.0) / 9.0;
    }
  }
  return std::sqrt(sum);
}

Result<Promise> kept(const Bench& bench, std::vector<camera::BoardView> views,
                     const camera::Calibration& before, const camera::PlannedBoard& planned,
                     const camera::CalibrationSettings& settings, Random& random) {
  auto view = photographed(bench, as_planned(bench, planned, before.px_per_m), random);
  if (!view) return tl::unexpected(view.error());
  views.push_back(std::move(*view));
  const auto found = camera::calibrate(views, settings);
  if (!found) return tl::unexpected(found.error());
  return Promise{planned.scale_sd_share, found->scale_errors.points, rms_error(bench, *found)};
}

Result<BoardSetUp> measured(Random& random) {
  const Bench bench = drawn_bench(random);
  BoardSetUp set_up;
  set_up.photographs = std::uniform_int_distribution<int>(1, 4)(random);
  std::vector<camera::BoardView> views;
  for (int i = 0; i < set_up.photographs; ++i) {
    auto view = photographed(bench, i == 0 ? bench.plane : drawn_place(bench, random), random);
    if (!view) return tl::unexpected(view.error());
    views.push_back(std::move(*view));
  }
  const camera::CalibrationSettings settings{bench.camera.width_px, bench.camera.height_px, 0.0, 0.0, {}, {}};
  const auto before = camera::calibrate(views, settings);
  if (!before) return tl::unexpected(before.error());
  set_up.before = before->scale_errors.points;
  const auto ranked = camera::rank_placements(
      *before, {camera::BoardKind::chessboard, bench.board.columns, bench.board.rows, bench.board.spacing_m},
      settings);
  if (ranked.empty()) return fail("nowhere to place it");
  const auto& other = ranked[std::uniform_int_distribution<std::size_t>(0, ranked.size() - 1)(random)];
  const auto advised = kept(bench, views, *before, ranked.front(), settings, random);
  const auto at_random = kept(bench, views, *before, other, settings, random);
  if (!advised || !at_random) return tl::unexpected(advised ? at_random.error() : advised.error());
  set_up.advised = *advised;
  set_up.random = *at_random;
  return set_up;
}

}  // namespace

std::vector<BoardSetUp> run(const BoardStudyPlan& plan, std::atomic<int>& done) {
  std::vector<BoardSetUp> set_ups(static_cast<std::size_t>(plan.set_ups));
  in_parallel(set_ups.size(), static_cast<unsigned>(plan.threads), [&](std::size_t i) {
    std::seed_seq words{static_cast<std::uint32_t>(plan.seed), static_cast<std::uint32_t>(i)};
    Random random(words);
    const auto set_up = measured(random);
    if (set_up)
      set_ups[i] = *set_up;
    else
      set_ups[i].failure = set_up.error().message;
    ++done;
  });
  return set_ups;
}

}  // namespace strobe::studies
