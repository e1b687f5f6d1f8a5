#include "host/config/rig_file.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <set>

#include "common/ball/ball.hpp"
#include "common/config/default_rig.hpp"
#include "common/config/files.hpp"
#include "common/config/toml_reader.hpp"
#include "common/messages/channels.hpp"
#include "common/messages/record.hpp"
#include "common/wire/lcm_url.hpp"
#include "host/config/notes.hpp"

namespace strobe::host {
namespace {

using config::read_file;
using config::TomlTable;

CommissionTable read_commission(config::TomlTable table) {
  CommissionTable read;
  if (table.has("record")) read.record = table.string("record");
  read.max_age_days = table.number_or("max_age_days", read.max_age_days, {0.01, 1e5});
  read.delay_tolerance_us = table.number_or("delay_tolerance_us", read.delay_tolerance_us, {0.1, 1000.0});
  read.jitter_limit_us = table.number_or("jitter_limit_us", read.jitter_limit_us, {0.1, 1000.0});
  read.skew_limit_us = table.number_or("skew_limit_us", read.skew_limit_us, {0.1, 1000.0});
  read.shutter_tolerance_ms =
      table.number_or("shutter_tolerance_ms", read.shutter_tolerance_ms, {0.1, 1000.0});
  read.brightness_ratio = table.number_or("brightness_ratio", read.brightness_ratio, {1.01, 100.0});
  read.balls = static_cast<int>(table.integer_or("balls", read.balls, {2.0, 1000.0}));
  if (table.has("board_folder")) read.board_folder = table.string("board_folder");
  read.board_columns = static_cast<int>(table.integer_or("board_columns", read.board_columns, {3.0, 100.0}));
  read.board_rows = static_cast<int>(table.integer_or("board_rows", read.board_rows, {3.0, 100.0}));
  if (table.has("board_spacing_mm")) read.board_spacing_mm = table.number("board_spacing_mm", {0.1, 1000.0});
  read.gravity_mps2 = table.number_or("gravity_mps2", read.gravity_mps2, {9.7, 9.9});
  return read;
}

BallSettings read_ball(TomlTable table, BallSettings ball = {}) {
  ball.kind_name = table.string_or("kind", "");
  ball.diameter_m = table.number_or("diameter_m", ball.diameter_m, {0.01, 1.0});
  ball.diameter_sd_m = table.number_or("diameter_sd_m", ball.diameter_sd_m, {0.0, 0.1});
  const auto take = [&table](const char* key, config::Range range, std::optional<double>& into) {
    if (const auto given = table.optional_number(key, range)) into = given;
  };
  take("mass_kg", {0.001, 10.0}, ball.mass_kg);
  take("alpha", {0.01, ball::kThinShellAlpha}, ball.alpha);
  take("fastest_spin_radps", {1.0, 1e6}, ball.fastest_spin_radps);
  take("alpha_sd", {0.0, ball::kThinShellAlpha}, ball.alpha_sd);
  ball.line = table.boolean_or("line", ball.line);
  return ball;
}

AnalysisSettings read_analysis(TomlTable table) {
  AnalysisSettings analysis;
  analysis.surface_angle_deg = table.optional_number("surface_angle_deg", {-60.0, 60.0});
  analysis.photograph_timeout_s =
      table.number_or("photograph_timeout_s", analysis.photograph_timeout_s, {0.01, 86400.0});
  analysis.px_per_m = table.optional_number("px_per_m", {1.0, 1e7});
  analysis.px_per_m_sd = table.optional_number("px_per_m_sd", {0.0, 1e6});
  analysis.gate_distance_m = table.optional_number("gate_distance_m", {0.0, 20.0});
  analysis.gate_distance_sd_m =
      table.number_or("gate_distance_sd_m", analysis.gate_distance_sd_m, {1e-4, 20.0});
  analysis.flash_time_sd_s = table.optional_number("flash_time_sd_us", {0.01, 100.0});
  if (analysis.flash_time_sd_s) *analysis.flash_time_sd_s *= 1e-6;
  analysis.machine_lag_sd_s = table.optional_number("machine_lag_sd_ms", {0.01, 1000.0});
  if (analysis.machine_lag_sd_s) *analysis.machine_lag_sd_s *= 1e-3;
  analysis.match_tolerance_percent =
      table.number_or("match_tolerance_percent", analysis.match_tolerance_percent, {0.001, 100.0});
  return analysis;
}

reduction::Record read_record(TomlTable table) {
  reduction::Record record;
  for (const std::string& key : table.keys()) {
    const std::string value = table.is_string(key) ? table.string(key) : fmt::format("{}", table.number(key));
    if (const auto problem = note_problem(key, value)) table.error_at(key, *problem);
    record[key] = value;
  }
  if (record.size() > messages::kMaxNotes) table.error_at("", "more than 64 notes");
  return record;
}

std::string read_lcm_url(TomlTable root) {
  const std::string url = root.string("lcm_url");
  if (const auto problem = wire::lcm_url_problem(url); !problem.empty()) root.error_at("lcm_url", problem);
  return url;
}

Duration in_us(TomlTable& table, const char* key) {
  return from_seconds(1e-6 * table.optional_number(key, {0.0, 1e9}).value_or(0.0));
}

bool gate_fitted(TomlTable root) {
  if (!root.has("sequencer")) return !root.has("lines") || root.table("lines").has("gate");
  const auto inputs = root.table("sequencer").strings_or("inputs", {"gate"});
  return std::find(inputs.begin(), inputs.end(), "gate") != inputs.end();
}

/// strobed's own tables, of which it checks the rest.
PlanLimits read_limits(TomlTable root, const ShotPlan& plan) {
  PlanLimits limits;
  TomlTable lamps = root.table("lamps"), tolerance = root.table("tolerance"), shutter = root.table("shutter");
  limits.lamp_period = in_us(lamps, "min_period_us");
  limits.lamp_pulse = in_us(lamps, "pulse_us");
  limits.flash_interval = in_us(lamps, "max_on_us") + in_us(tolerance, "spin_us");
  if (lamps.has("max_flashes_per_shot"))
    limits.max_flashes = static_cast<std::int32_t>(lamps.integer("max_flashes_per_shot", {1, kMaxFlashes}));
  if (const auto most_s = shutter.optional_number("max_open_s", {0.0, to_seconds(kLongestOfPlan)}))
    limits.longest_exposure = from_seconds(*most_s);
  limits.gate_fitted = gate_fitted(root);
  limits.impact_at = plan.impact_at;
  return limits;
}

void accept_firmware_tables(TomlTable root) {
  const std::set<std::string> own{"rig",    "lcm_url", "commands", "ball",       "analysis", "camera",
                                  "record", "plan",    "machine",  "laboratory", "report",   "commission"};
  for (const std::string& key : root.keys()) {
    if (!own.contains(key) && root.is_table(key)) root.table(key).accept_all();
  }
}

}  // namespace

Result<RigFile> read_rig(std::string_view text, const std::string& file_name) {
  config::TomlReader reader(text, file_name);
  TomlTable root = reader.root();
  RigFile rig;
  rig.text = text;
  rig.rig = root.string("rig");
  if (root.has("rig") && !messages::valid_rig_name(rig.rig)) {
    root.error_at("rig", "must be 1 to 24 letters, digits, - or _");
  }
  if (root.has("lcm_url")) rig.lcm_url = read_lcm_url(root);
  TomlTable commands = root.table("commands");
  if (commands.has("key_file")) rig.key_file = commands.string("key_file");
  rig.ball = read_ball(root.table("ball"));
  rig.analysis = read_analysis(root.table("analysis"));
  rig.camera = read_camera(root.table("camera"));
  rig.record = read_record(root.table("record"));
  rig.statements = read_statements(root);
  rig.instruments = read_instruments(root.table("report"));
  rig.commission = read_commission(root.table("commission"));
  rig.plan = read_plan_table(root.table("plan"), {});
  TomlTable machine = root.table("machine");
  if (const auto lag = machine.optional_number("lag_ms", {0.0, 60000.0})) rig.machine_lag_s = *lag * 1e-3;
  if (const auto pulse = machine.optional_number("pulse_ms", {0.0, 60000.0}))
    rig.machine_pulse_s = *pulse * 1e-3;
  if (const auto lag = root.table("shutter").optional_number("lag_ms", {0.0, 60000.0}))
    rig.shutter_lag_s = *lag * 1e-3;
  machine.accept_all();
  rig.limits = read_limits(root, rig.plan.even);
  accept_firmware_tables(root);
  if (const auto bad = reader.error()) return fail(bad->message);
  return rig;
}

std::string kept_ball_file(const BallSettings& ball) {
  if (ball.kind_name.empty()) return "";
  return "ball-" + std::filesystem::path(ball.kind_name).stem().string() + ".toml";
}

BallSettings settings_of(const balls::Kind& kind) {
  BallSettings ball;
  ball.kind_name = kind.name;
  ball.kind = kind;
  ball.diameter_m = kind.diameter_m.value;
  ball.diameter_sd_m = kind.diameter_m.sd;
  ball.mass_kg = kind.mass_kg.value;
  ball.alpha = kind.alpha.value;
  ball.alpha_sd = kind.alpha.sd;
  ball.line = kind.marking == balls::Marking::line;
  return ball;
}

Result<RigFile> with_ball_kind(RigFile rig, std::string_view text, const std::string& file_name) {
  auto kind = balls::read_ball_kind(text, file_name);
  if (!kind) return tl::unexpected(kind.error());
  kind->name = std::filesystem::path(rig.ball.kind_name).stem().string();
  config::TomlReader reader(rig.text, "rig.toml");  // read before
  rig.ball = read_ball(reader.root().table("ball"), settings_of(*kind));
  rig.ball_text = text;
  return rig;
}

namespace {

/// The ball's file: as a session keeps it, else where the rig file says.
Result<RigFile> with_named_ball(RigFile rig, const std::filesystem::path& beside, const std::string& file) {
  if (rig.ball.kind_name.empty()) return rig;
  const std::filesystem::path own = beside / kept_ball_file(rig.ball);
  std::error_code error;
  const bool kept = std::filesystem::is_regular_file(own, error);
  const bool is_path = rig.ball.kind_name.ends_with(".toml");
  const auto path = kept      ? Result<std::string>(own.string())
                    : is_path ? Result<std::string>((beside / rig.ball.kind_name).string())
                              : balls::ball_kind_path(rig.ball.kind_name);
  if (!path) return fail(fmt::format("{}: ball.kind: {}", file, path.error().message));
  const auto text = read_file(*path);
  if (!text) return fail(fmt::format("{}: ball.kind: {}", file, text.error().message));
  return with_ball_kind(std::move(rig), *text, *path);
}

}  // namespace

Result<RigFile> load_rig(const std::string& path) {
  const auto found = config::rig_file_or_example(path, "--rig");
  if (!found) return tl::unexpected(found.error());
  const std::string& file = *found;
  const auto text = read_file(file);
  if (!text) return fail("rig file " + text.error().message);
  auto rig = read_rig(*text, file);
  const std::filesystem::path beside = file == "-" ? "" : std::filesystem::path(file).parent_path();
  if (!rig) return rig;
  if (rig->key_file) rig->key_file = (beside / *rig->key_file).string();
  if (rig->camera.folder) rig->camera.folder = (beside / *rig->camera.folder).string();
  if (rig->commission.board_folder)
    rig->commission.board_folder = (beside / *rig->commission.board_folder).string();
  rig = with_named_ball(*std::move(rig), beside, file);
  if (!rig || !rig->camera.calibration) return rig;
  const std::string name = (beside / *rig->camera.calibration).string();
  const auto calibration = read_file(name);
  if (!calibration)
    return fail(fmt::format("{}: camera.calibration: {} (strobe calibrate --rig {} writes it)", file,
                            calibration.error().message, file));
  const auto calibrated = with_calibration(rig->camera, *calibration, name);
  if (!calibrated) return tl::unexpected(calibrated.error());
  rig->calibration_text = *calibration;
  rig->camera = *calibrated;
  return rig;
}

}  // namespace strobe::host
