#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "sim/commands/commands.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/photograph/board.hpp"
#include "sim/photograph/render.hpp"

namespace strobe::sim {

namespace {

namespace fs = std::filesystem;

BoardView view_by_options(const BoardOptions& options) {
  BoardView view;
  BoardCamera& camera = view.camera;
  camera.width_px = options.width_px;
  camera.height_px = options.height_px;
  camera.focal_px = options.focal_px;
  std::copy(options.lens.begin(), options.lens.end(), camera.lens.begin());
  view.place.distance_m = options.distance_m;
  return view;
}

Result<BoardView> view_of(const BoardOptions& options) {
  if (options.scene.empty()) return view_by_options(options);
  return load_scene(options.scene).map([](const Scene& scene) { return board_view(scene); });
}

Board board_of(const BoardOptions& options) {
  const BoardPrint print = options.board == "chessboard" ? BoardPrint::chessboard
                           : options.board == "circles"  ? BoardPrint::circles
                                                         : BoardPrint::staggered;
  return {print, options.columns, options.rows, options.spacing_mm * 1e-3};
}

/// The board square to the lens, then slanted about the four directions that calibrations ask for.
BoardPlace slanted(BoardPlace place, int index) {
  if (index == 0) return place;
  constexpr double kSlant_deg = 25.0;
  constexpr std::array<std::array<double, 2>, 4> kSlants{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  const auto& slant = kSlants[static_cast<std::size_t>(index - 1) % kSlants.size()];
  for (std::size_t i = 0; i < 3; ++i) place.turns_deg[i] += i < 2 ? kSlant_deg * slant[i] : 5.0 * index;
  return place;
}

}  // namespace

int board_command(const BoardOptions& options) {
  const auto view = view_of(options);
  if (!view) return report_error(view.error().message, 2);
  std::error_code error;
  fs::create_directories(options.folder, error);
  const fs::path truth_path = fs::path(options.folder) / "truth.jsonl";
  std::ofstream truth(truth_path);
  if (!truth) return report_error(truth_path.string() + ": cannot be written", 2);
  const Board board = board_of(options);
  for (int i = 0; i <= options.slanted; ++i) {
    const std::string name = i == 0 ? "plane.tif" : fmt::format("slanted_{}.tif", i);
    const BoardPlace place = slanted(view->place, i);
    const auto seed = options.seed + static_cast<std::uint64_t>(i);
    const BoardPhotograph photograph = photograph_board(view->camera, board, place, seed);
    if (const auto written =
            write_photograph(fs::path(options.folder) / name, photograph.pixels, PhotographFormat::tiff);
        !written)
      return report_error(written.error().message, 1);
    const std::string line = board_truth_json(view->camera, board, place, photograph, name);
    truth << line << '\n';
    options.json ? fmt::print("{}\n", line) : fmt::print("{}/{}\n", options.folder, name);
  }
  if (!truth.flush()) return report_error(truth_path.string() + ": not everything could be written", 1);
  if (std::fflush(stdout) != 0) return report_error("standard output: not everything could be written", 1);
  return 0;
}

}  // namespace strobe::sim
