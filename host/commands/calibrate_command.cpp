// strobe calibrate: photographs of a printed board to the calibration file that the rig file names.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/camera/board_plan.hpp"
#include "host/camera/calibration.hpp"
#include "host/commands/command.hpp"
#include "host/commands/shared_options.hpp"
#include "host/config/rig_file.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::host {
namespace {

struct CalibrateOptions {
  std::vector<std::string> images;
  std::string rig_path;
  std::string board = "chessboard";
  int columns = 9;
  int rows = 6;
  double spacing_mm = 0.0;
  double spacing_sd_percent = 0.05;
  double off_plane_sd_mm = 1.0;
  std::optional<double> lens_distance_m;
  std::optional<double> lens_distance_sd_m;
  std::vector<double> surface;  ///< image px: x, row, x, row
  double surface_sd_px = 0.5;
  std::string date;  ///< empty: today
  double tolerance_percent = 0.2;
  int advise = 0;  ///< photographs to plan
  std::string advise_figure;
  bool dry = false;
  bool json = false;
};

camera::BoardPattern pattern_of(const CalibrateOptions& options) {
  camera::BoardPattern pattern;
  pattern.kind = options.board == "chessboard" ? camera::BoardKind::chessboard
                 : options.board == "circles"  ? camera::BoardKind::circles
                                               : camera::BoardKind::staggered_circles;
  pattern.columns = options.columns;
  pattern.rows = options.rows;
  pattern.spacing_m = options.spacing_mm * 1e-3;
  return pattern;
}

struct Boards {
  std::vector<camera::BoardView> views;
  std::vector<std::string> left_out;  ///< "slanted_3.tif: why it is of no use"
  int width_px = 0;
  int height_px = 0;
};

/// Fails with "IMAGE: what".
Result<camera::BoardView> find_view(const std::string& image, const camera::BoardPattern& pattern,
                                    Boards& boards) {
  const auto photograph = digitize::load_photograph(image);
  if (!photograph) return tl::unexpected(photograph.error());
  if (boards.views.empty()) {
    boards.width_px = photograph->width();
    boards.height_px = photograph->height();
  } else if (photograph->width() != boards.width_px || photograph->height() != boards.height_px) {
    return fail(fmt::format("{}: {} x {} pixels, but the first photograph has {} x {}", image,
                            photograph->width(), photograph->height(), boards.width_px, boards.height_px));
  }
  return camera::find_board(*photograph, pattern);
}

/// The first photograph is the scale; without any of the slanted ones that were given the lens' place would
/// be lost unasked.
Result<Boards> find_boards(const CalibrateOptions& options) {
  Boards boards;
  const std::size_t given = options.images.size();
  for (std::size_t i = 0; i < given; ++i) {
    if (given > 1)
      std::fprintf(stderr, "strobe: calibrate: %zu of %zu: %s\n", i + 1, given, options.images[i].c_str());
    auto view = find_view(options.images[i], pattern_of(options), boards);
    if (view) {
      boards.views.push_back(std::move(*view));
    } else if (i > 0) {
      std::fprintf(stderr, "strobe: calibrate: left out: %s\n", view.error().message.c_str());
      boards.left_out.push_back(view.error().message);
    } else {
      return fail(view.error().message +
                  (given > 1 ? "; the first photograph gives the scale in the balls' plane: none of the "
                               "others can stand in for it"
                             : ""));
    }
  }
  if (given > 1 && boards.views.size() == 1)
    return fail(
        fmt::format("of {} photographs only the first, {}, is of use, and at least one slanted one is "
                    "needed to tell where the lens is: take them again, or give the first alone, with "
                    "--lens-distance-m",
                    given, options.images[0]));
  return boards;
}

/// Six significant digits would do; the file keeps what was computed.
CameraTable table_of(const CalibrateOptions& options, const camera::Calibration& found,
                     const Boards& boards) {
  CameraTable table;
  table.calibrated = options.date.empty() ? date_of(std::chrono::system_clock::now()) : options.date;
  table.board = camera::describe(pattern_of(options));
  table.photographs = static_cast<int>(found.fit.homographies.size());
  if (!boards.left_out.empty()) table.left_out = fmt::format("{}", fmt::join(boards.left_out, "; "));
  table.residual_px = found.fit.rms_px;
  table.width_px = boards.width_px;
  table.height_px = boards.height_px;
  table.px_per_m = found.px_per_m;
  // The points' share is in the map's errors, where it is another from place to place.
  table.px_per_m_sd = found.px_per_m * found.scale_errors.common();
  camera::set_map(found, table);
  if (found.place) {
    const auto& viewpoint = found.place->viewpoint;
    table.viewpoint_px = {viewpoint.foot_px.x, viewpoint.foot_px.y, viewpoint.distance_px};
    table.viewpoint_sd_px = found.place->distance_sd_px;
    table.tilt_deg = found.place->tilt_rad * 180.0 / std::numbers::pi;
  }
  if (options.surface.size() == 4) {
    const auto plane = found.map();
    const cv::Point2d a = plane.to_plane({options.surface[0], options.surface[1]});
    const cv::Point2d b = plane.to_plane({options.surface[2], options.surface[3]});
    table.surface_px = {a.x, a.y, b.x, b.y};
    table.surface_sd_px = options.surface_sd_px;
  }
  return table;
}

using nlohmann::ordered_json;

using Plan = std::optional<camera::BoardPlan>;

ordered_json plan_json(const Plan& plan) {
  if (!plan) return nullptr;
  ordered_json next = ordered_json::array();
  for (const camera::PlannedBoard& board : plan->next) {
    ordered_json outline = ordered_json::array();
    for (const cv::Point2d& p : board.outline_px) outline.push_back({p.x, p.y});
    next.push_back({{"placement", camera::describe(board.placement)},
                    {"distance_m", plan->distance_m * board.placement.distance_share},
                    {"slant_deg", board.placement.slant_rad * 180.0 / std::numbers::pi},
                    {"outline_px", outline},
                    {"sd_share_points", board.scale_sd_share}});
  }
  return {{"sd_share_points", plan->scale_sd_share},
          {"sd_share_points_of_known_lens", plan->limit_share},
          {"lens_distance_known", plan->distance_known},
          {"lens_distance_sd_m", messages::or_null(plan->next_distance_sd_m)},
          {"next", next}};
}

void print_json(const CalibrateOptions& options, const Boards& boards, const CameraTable& table,
                const camera::Calibration& found, const Plan& plan) {
  ordered_json out;
  out["px_per_m"] = *table.px_per_m;
  out["px_per_m_sd"] = found.px_per_m_sd();
  out["sd_share"] = {{"points", found.scale_errors.points},
                     {"print", found.scale_errors.print},
                     {"off_plane", messages::or_null(found.scale_errors.off_plane)}};
  out["residual_px"] = found.fit.rms_px;
  out["residuals_px"] = found.fit.view_rms_px;
  out["points"] = found.fit.points;
  out["outliers"] = found.fit.outliers;
  out["covered_share"] = found.covered_share;
  out["lens_distortion"] = table.map->lens_distortion;
  out["lens_terms"] = found.fit.lens_terms;
  out["largest_shift_px"] = found.largest_shift_px;
  out["tilt_deg"] = messages::or_null(table.tilt_deg);
  out["lens_distance_m"] = ordered_json();
  out["lens_distance_sd_m"] = ordered_json();
  if (found.place) {
    out["lens_distance_m"] = found.place->viewpoint.distance_px / found.px_per_m;
    out["lens_distance_sd_m"] = found.place->distance_sd_px / found.px_per_m;
  }
  out["calibrated"] = *table.calibrated;
  out["photographs"] = *table.photographs;
  out["left_out"] = boards.left_out;
  out["remarks"] = found.remarks;
  out["too_poor"] = messages::or_null(found.too_poor);
  if (plan) out["advice"] = plan_json(plan);
  out["inputs"] = {{"images", options.images},
                   {"board", options.board},
                   {"columns", options.columns},
                   {"rows", options.rows},
                   {"spacing_mm", options.spacing_mm},
                   {"spacing_sd_percent", options.spacing_sd_percent},
                   {"off_plane_sd_mm", options.off_plane_sd_mm},
                   {"tolerance_percent", options.tolerance_percent}};
  std::printf("%s\n", messages::json_text(out).c_str());
}

void print_text(const Boards& boards, const CameraTable& table, const camera::Calibration& found) {
  fmt::print("scale          {:.3f} px/m, sd {:.3f} px/m ({:.4f} %: points {:.4f}, print {:.4f}, place {})\n",
             *table.px_per_m, found.px_per_m_sd(), 100.0 * found.scale_errors.total(),
             100.0 * found.scale_errors.points, 100.0 * found.scale_errors.print,
             found.scale_errors.off_plane ? fmt::format("{:.4f}", 100.0 * *found.scale_errors.off_plane)
                                          : "unknown");
  fmt::print("residuals      {:.3f} px rms over {} points, {} left out\n", found.fit.rms_px, found.fit.points,
             found.fit.outliers);
  fmt::print("lens           moves the corners by up to {:.2f} px ({} of 4 terms determined by the board)\n",
             found.largest_shift_px, found.fit.lens_terms);
  if (found.place) {
    fmt::print("lens' place    {:.3f} m from the plane, sd {:.3f} m; tilt {:.2f} degrees\n",
               found.place->viewpoint.distance_px / found.px_per_m,
               found.place->distance_sd_px / found.px_per_m, *table.tilt_deg);
  }
  fmt::print("board          {}, over {:.0f} % of the photograph; {} photograph{}\n", *table.board,
             100.0 * found.covered_share, *table.photographs, *table.photographs == 1 ? "" : "s");
  for (const std::string& why : boards.left_out) fmt::print("left out       {}\n", why);
}

/// What the points' share of the scale's sd would be with each further photograph.
void print_plan(const camera::BoardPlan& plan) {
  double before = plan.scale_sd_share;
  for (std::size_t i = 0; i < plan.next.size(); ++i) {
    const camera::PlannedBoard& board = plan.next[i];
    fmt::print("next {:<10}{}: the scale's sd by points goes from {:.2g} % to {:.2g} %\n", i + 1,
               camera::describe(board.placement), 100.0 * before, 100.0 * board.scale_sd_share);
    before = board.scale_sd_share;
  }
  if (plan.next.empty()) {
    fmt::print("next           nowhere: the board slanted is not seen as a whole; use a smaller one\n");
    return;
  }
  if (!plan.distance_known)
    fmt::print("               slants as with a usual lens: these photographs do not tell where it is{}\n",
               plan.next_distance_sd_m ? ", with those planned they will" : "");
  else if (plan.distance_sd_m && plan.next_distance_sd_m)
    fmt::print("               lens' place: sd from {:.2g} m to {:.2g} m\n", *plan.distance_sd_m,
               *plan.next_distance_sd_m);
  // Of what is left a tenth is the lens'.
  if (before < 1.1 * plan.limit_share)
    fmt::print(
        "               further ones cannot bring it below {:.2g} %: for that, a larger board or more "
        "squares "
        "in the balls' plane\n",
        100.0 * plan.limit_share);
}

Plan plan_next(const CalibrateOptions& options, const camera::Calibration& found,
               const camera::CalibrationSettings& settings) {
  if (options.advise == 0) return std::nullopt;
  return camera::plan_boards(found, pattern_of(options), settings, options.advise);
}

/// Where the calibration goes: beside the rig file, as that says.
Result<std::filesystem::path> calibration_path(const std::string& rig_path) {
  const auto text = read_option_file("--rig", rig_path);
  if (!text) return tl::unexpected(text.error());
  const auto rig = read_rig(*text, rig_path);
  if (!rig) return tl::unexpected(rig.error());
  const std::filesystem::path path(rig_path);
  if (!rig->camera.calibration || *rig->camera.calibration == path.filename())
    return fail(rig_path + ": camera.calibration: must name the file to write, such as \"camera.toml\"");
  return path.parent_path() / *rig->camera.calibration;
}

int run_calibrate(const CalibrateOptions& options) {
  if (!options.date.empty() && !days_since(options.date, {})) {
    return bad_input("calibrate: --date: must be a date, such as 2026-11-21");
  }
  std::filesystem::path path;
  if (!options.rig_path.empty()) {
    const auto named = calibration_path(options.rig_path);
    if (!named) return bad_input("calibrate: " + named.error().message);
    path = *named;
  }
  const auto boards = find_boards(options);
  if (!boards) return bad_input("calibrate: " + boards.error().message);
  camera::CalibrationSettings settings;
  settings.width_px = boards->width_px;
  settings.height_px = boards->height_px;
  settings.spacing_sd_share = options.spacing_sd_percent / 100.0;
  settings.off_plane_sd_m = options.off_plane_sd_mm * 1e-3;
  settings.lens_distance_m = options.lens_distance_m;
  settings.lens_distance_sd_m = options.lens_distance_sd_m;
  settings.tolerance_share = options.tolerance_percent / 100.0;
  const auto found = camera::calibrate(boards->views, settings);
  if (!found) return bad_input("calibrate: " + found.error().message);
  const CameraTable table = table_of(options, *found, *boards);
  if (!path.empty() && !options.dry && !found->too_poor) {
    if (const auto done = config::write_file(path.string(), calibration_text(table)); !done)
      return bad_input("calibrate: " + done.error().message);
  }
  const Plan plan = plan_next(options, *found, settings);
  if (plan && !options.advise_figure.empty()) {
    const std::string svg = camera::plan_svg(*plan, *found, pattern_of(options), settings);
    if (const auto done = config::write_file(options.advise_figure, svg); !done)
      return bad_input("calibrate: --advise-figure: " + done.error().message);
  }
  if (options.json) {
    print_json(options, *boards, table, *found, plan);
  } else {
    print_text(*boards, table, *found);
    if (plan) print_plan(*plan);
  }
  for (const std::string& remark : found->remarks) {
    std::fprintf(stderr, "strobe: calibrate: note: %s\n", remark.c_str());
  }
  if (found->too_poor) return failed("calibrate: refused, no file was written: " + *found->too_poor);
  if (path.empty() && !options.dry)
    std::fputs(
        "strobe: calibrate: no file was written: --rig RIG.toml writes the one that its "
        "camera.calibration names\n",
        stderr);
  return kDone;
}

}  // namespace

void add_calibrate_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command =
      app.add_subcommand("calibrate", "Measure scale, tilt and lens from photographs of a board");
  command
      ->add_option(
          "images", options->images,
          "Photographs of the board: the first with the board in the plane in which balls fly, the others "
          "slanted, anywhere")
      ->required();
  command->add_option("--rig", options->rig_path,
                      "Rig file whose camera.calibration names the file to write");
  command->add_option("--board", options->board, "What is printed")
      ->check(CLI::IsMember({"chessboard", "circles", "staggered"}))
      ->capture_default_str();
  command->add_option("--columns", options->columns, "Inner corners, or discs, along a row")
      ->check(CLI::Range(3, 100))
      ->capture_default_str();
  command->add_option("--rows", options->rows, "Rows of inner corners or discs")
      ->check(CLI::Range(3, 100))
      ->capture_default_str();
  command
      ->add_option("--spacing-mm", options->spacing_mm,
                   "Side of a square, or distance of discs in a row, as measured on the print (over many)")
      ->check(CLI::Range(0.1, 1000.0))
      ->required();
  command
      ->add_option("--spacing-sd-percent", options->spacing_sd_percent,
                   "Standard deviation of the spacing, in percent")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command
      ->add_option("--off-plane-sd-mm", options->off_plane_sd_mm,
                   "Standard deviation of the board's distance from the plane in which balls fly")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  command
      ->add_option("--lens-distance-m", options->lens_distance_m,
                   "Distance from lens to plane, measured by tape")
      ->check(CLI::Range(0.01, 1000.0));
  command
      ->add_option("--lens-distance-sd-m", options->lens_distance_sd_m,
                   "Its standard deviation (default 1 %)")
      ->check(CLI::Range(1e-6, 1000.0));
  command
      ->add_option("--surface", options->surface,
                   "Two points of the surface's line on the photograph: column row column row [px]")
      ->expected(4);
  command
      ->add_option("--surface-sd-px", options->surface_sd_px, "Standard deviation of each of these numbers")
      ->check(CLI::Range(1e-4, 1000.0))
      ->capture_default_str();
  command
      ->add_option("--tolerance-percent", options->tolerance_percent,
                   "Refuse a calibration whose scale is more uncertain than this, rms over the photograph")
      ->check(CLI::Range(1e-6, 100.0))
      ->capture_default_str();
  auto* advise =
      command
          ->add_option("--advise", options->advise,
                       "Say where the next so many photographs of the board would help most, 1 to 9")
          ->check(CLI::Range(1, 9));
  command->add_option("--advise-figure", options->advise_figure, "Their outlines in the view, as an SVG file")
      ->needs(advise);
  command->add_option("--date", options->date, "Day of the photographs, such as 2026-11-21; default: today");
  command->add_flag("--dry", options->dry, "Write no file");
  command->add_flag("--json", options->json, "One JSON object");
  command_line::for_experts(
      *command, {"--spacing-sd-percent", "--off-plane-sd-mm", "--lens-distance-m", "--lens-distance-sd-m",
                 "--surface", "--surface-sd-px", "--tolerance-percent", "--advise-figure", "--date"});
  command->footer(
      "Example: strobe calibrate plane.tif slanted1.tif slanted2.tif --spacing-mm 20.02 --rig rig.toml\n"
      "One photograph gives scale, tilt and lens; with slanted ones, or --lens-distance-m, also how balls "
      "show away from the middle. `strobe digitize --rig` then uses all of it.");
  command->callback([options, &exit_status] { exit_status = run_calibrate(*options); });
}

}  // namespace strobe::host
