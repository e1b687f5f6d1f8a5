#include "host/commission/board_step.hpp"

#include <vector>

#include "sim/loading/load_scene.hpp"
#include "sim/photograph/board.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;

/// The scene's board in the plane, then slanted: where its corners are seen, without noise.
struct Boards {
  std::vector<camera::BoardView> views;
  int width_px = 0, height_px = 0;
};

Boards boards_of(const std::string& camera, double spacing_m = 0.06) {
  const auto scene = sim::parse_scene(
      "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n"
      "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n"
      "[camera]\npx_per_m = 2500\norigin_x_px = 940\norigin_y_px = 190\ndistance_m = 2.5\n" +
          camera,
      "board.toml");
  if (!scene) FAIL(scene.error().message.c_str());
  const sim::Board board{sim::BoardPrint::chessboard, 9, 6, spacing_m};
  Boards boards;
  for (int slant = 0; slant < 3; ++slant) {
    sim::BoardView view = sim::board_view(*scene);
    if (slant > 0) view.place.turns_deg[static_cast<std::size_t>(slant - 1)] += 20.0;
    boards.width_px = view.camera.width_px, boards.height_px = view.camera.height_px;
    camera::BoardView seen{"board", {}, {}};
    for (int row = 0; row < board.rows; ++row) {
      for (int column = 0; column < board.columns; ++column) {
        seen.board_m.emplace_back(spacing_m * column, spacing_m * row);
        seen.image_px.push_back(sim::image_of(view.camera, board, view.place, seen.board_m.back()));
      }
    }
    boards.views.push_back(std::move(seen));
  }
  return boards;
}

BoardCheck check_of(const Boards& boards, double px_per_m = 2500.0) {
  const auto check = check_board(boards.views, boards.width_px, boards.height_px,
                                 digitize::PlaneMap::uncalibrated(boards.height_px), px_per_m);
  if (!check) FAIL(check.error().message.c_str());
  return *check;
}

}  // namespace

TEST_GROUP(BoardCheck){};

TEST(BoardCheck, PassesACalibrationThatIsRight) {
  const BoardCheck check = check_of(boards_of(""));
  DOUBLES_EQUAL(0.0, check.scale_off, 1e-6);  // places have no noise
  DOUBLES_EQUAL(0.0, check.across, 1e-5);
  CHECK(check.covered > 0.4);
  const StepResult result = judge_board(check);
  CHECK_TEXT(result.state == StepState::passed, result.words.c_str());
}

TEST(BoardCheck, FindsAScaleThatIsOnePercentOff) {
  const BoardCheck check = check_of(boards_of(""), 2525.0);
  DOUBLES_EQUAL(0.01, check.scale_off, 1e-5);
  CHECK_EQUAL("scale_off", judge_board(check).fault);
}

TEST(BoardCheck, FindsACameraThatHasBeenTurned) {
  const BoardCheck check = check_of(boards_of("swing_deg = 1.5\n"));
  // Lengths go as (1 + x·tan(a)/L) to the -1.5th power on average, over 1802 px of 2500 px/m.
  DOUBLES_EQUAL(1.5 * 0.72 * 0.02619 / 2.5, std::abs(check.across), 0.001);
  CHECK_EQUAL("camera_tilted", judge_board(check).fault);
}

TEST(BoardCheck, WantsTheViewCovered) {
  const BoardCheck check = check_of(boards_of("", 0.03));
  CHECK(check.covered < 0.2);
  CHECK_EQUAL("board_too_small", judge_board(check).fault);
}
