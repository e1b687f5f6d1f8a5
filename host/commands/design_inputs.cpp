#include "host/commands/design_inputs.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <utility>

#include "common/command_line/command_line.hpp"
#include "common/config/toml_reader.hpp"
#include "common/units/angles.hpp"
#include "host/archive/read_session.hpp"
#include "host/assembly/coded_spacing.hpp"
#include "host/commands/shared_options.hpp"
#include "host/series/sample_size.hpp"
#include "host/series/select.hpp"

namespace strobe::host {
namespace {

using reduction::Quantity;

/// Mean and scatter of a session's shots; the scatter of their noise is taken off.
Result<Spread> spread_of(const SeriesSummary& summary, Quantity q, double noise) {
  const QuantitySummary& s = summary.quantities[static_cast<std::size_t>(q)];
  if (s.n == 0) return fail(fmt::format("its shots have no {}", reduction::name(q)));
  const double scatter = s.scatter_sd.value_or(0.0);
  return Spread{s.mean, std::sqrt(std::max(0.0, scatter * scatter - noise * noise))};
}

/// Root mean square over the shots that count of what is not shared.
double noise_of(const std::vector<Shot>& shots, Quantity q) {
  double squares = 0.0;
  int n = 0;
  for (const Shot& shot : shots) {
    const auto& sd = shot.readout.sd[q];
    if (shot.rejected || !sd) continue;
    squares += *sd * *sd;
    ++n;
  }
  return n > 0 ? std::sqrt(squares / n) : 0.0;
}

/// The balls of a session, which must be of one condition.
Result<void> like_session(const DesignOptions& options, ExpectedBall& ball) {
  const auto session = read_session(options.like, {options.rig_path, "", reading_notes(options.like)});
  if (!session) return tl::unexpected(session.error());
  auto selected = select_shots(series_shots(*session, ""), {});
  if (!selected) return fail("--like: " + selected.error().message);
  if (selected->groups.size() != 1)
    return fail(
        fmt::format("--like: {}: {} conditions, a design is for one", options.like, selected->groups.size()));
  const std::vector<Shot>& shots = selected->groups.front().shots;
  const SeriesSummary summary = summarize("", shots);
  const auto take = [&](Quantity q, double unit, Spread& spread) -> Result<void> {
    auto found = spread_of(summary, q, noise_of(shots, q));
    if (!found) return fail("--like: " + options.like + ": " + found.error().message);
    spread = {unit * found->mean, unit * found->sd};
    return {};
  };
  struct Taken {
    Quantity q;
    double unit;
    Spread& spread;
  };
  for (const Taken& t :
       {Taken{Quantity::v_td_mps, 1.0, ball.speed_mps},
        Taken{Quantity::theta_in_deg, kPi / 180.0, ball.angle_rad},
        Taken{Quantity::omega_td_radps, 1.0, ball.spin_radps}, Taken{Quantity::e, 1.0, ball.e},
        Taken{Quantity::mu, 1.0, ball.mu}, Taken{Quantity::dwell_time_ms, 1e-3, ball.dwell_s}}) {
    if (auto taken = take(t.q, t.unit, t.spread); !taken) return taken;
  }
  return {};
}

/// The file with what its parents say besides, which lie beside it as NAME.toml.
Result<config::TomlReader> read_scene(const std::string& path, int depth = 0) {
  const auto text = read_option_file("--scene", path);
  if (!text) return tl::unexpected(text.error());
  config::TomlReader scene(*text, path);
  const std::string parent = scene.root().string_or("inherits", "");
  if (parent.empty()) return scene;
  if (depth > 8) return fail("--scene: " + path + ": inherits: more than eight scenes deep");
  auto read =
      read_scene((std::filesystem::path(path).parent_path() / (parent + ".toml")).string(), depth + 1);
  if (!read) return tl::unexpected(read.error());
  scene.inherit(std::move(*read));
  return scene;
}

/// What a simulator's scene says of machine and bounce; the rest is the rig file's.
Result<void> of_scene(const std::string& path, ExpectedBall& ball) {
  auto scene = read_scene(path);
  if (!scene) return tl::unexpected(scene.error());
  const auto spread = [](config::TomlTable& table, const char* mean, const char* sd, double unit, Spread& s) {
    s.mean = unit * table.number_or(mean, s.mean / unit);
    s.sd = unit * table.number_or(sd, 0.0);
  };
  config::TomlTable machine = scene->root().table("machine");
  spread(machine, "speed_mps", "speed_sd_mps", 1.0, ball.speed_mps);
  spread(machine, "angle_deg", "angle_sd_deg", kPi / 180.0, ball.angle_rad);
  spread(machine, "spin_radps", "spin_sd_radps", 1.0, ball.spin_radps);
  config::TomlTable bounce = scene->root().table("bounce");
  spread(bounce, "e", "e_sd", 1.0, ball.e);
  spread(bounce, "mu", "mu_sd", 1.0, ball.mu);
  spread(bounce, "dwell_ms", "dwell_sd_ms", 1e-3, ball.dwell_s);
  scene->root().accept_all();
  if (const auto problem = scene->error()) return fail("--scene: " + problem->message);
  return {};
}

void take_given(const DesignOptions& o, ExpectedBall& ball) {
  const auto set = [](const std::optional<double>& given, double unit, double& value) {
    if (given) value = unit * *given;
  };
  set(o.speed_mps, 1.0, ball.speed_mps.mean);
  set(o.speed_sd_mps, 1.0, ball.speed_mps.sd);
  if (o.angle_deg) ball.angle_rad.mean = -radians(std::abs(*o.angle_deg));
  set(o.angle_sd_deg, kPi / 180.0, ball.angle_rad.sd);
  set(o.spin_radps, 1.0, ball.spin_radps.mean);
  set(o.spin_sd_radps, 1.0, ball.spin_radps.sd);
  set(o.e, 1.0, ball.e.mean);
  set(o.e_sd, 1.0, ball.e.sd);
  set(o.mu, 1.0, ball.mu.mean);
  set(o.mu_sd, 1.0, ball.mu.sd);
  set(o.dwell_ms, 1e-3, ball.dwell_s.mean);
  set(o.dwell_sd_ms, 1e-3, ball.dwell_s.sd);
}

Result<ExpectedBall> expected_ball(const DesignOptions& options, const RigFile& rig) {
  ExpectedBall ball;
  ball.ball = {rig.ball.diameter_m, rig.ball.mass_kg.value_or(ball::kThesisMass_kg),
               rig.ball.alpha.value_or(ball::kMeasuredAlpha)};
  ball.kind = rig.ball.kind;
  if (ball.kind) {
    ball.e.mean = ball.kind->contact.e;
    ball.mu.mean = ball.kind->contact.mu;
    ball.dwell_s.mean = ball.kind->contact.dwell_s;
  }
  if (const auto t = note_number(rig.record, "temperature_c"))
    ball.air_density_kgpm3 = flight::air_density_kgpm3(*t);
  if (!options.like.empty()) {
    if (auto read = like_session(options, ball); !read) return tl::unexpected(read.error());
  }
  if (!options.scene.empty()) {
    if (auto read = of_scene(options.scene, ball); !read) return tl::unexpected(read.error());
  }
  if (options.like.empty() && options.scene.empty() && !(options.speed_mps && options.angle_deg))
    return fail("which ball? --speed and --angle, --like SESSION or --scene FILE");
  take_given(options, ball);
  if (auto problem = problem_of(ball)) return fail("the ball's " + *problem);
  return ball;
}

Result<SetUp> set_up(const DesignOptions& o, const RigFile& rig) {
  auto s = set_up_of(rig);
  if (!s) return s;
  if (o.scale_sd_percent) {
    s->camera.px_per_m_sd = 1e-2 * *o.scale_sd_percent * s->px_per_m;
    s->camera.map_errors.clear();
  }
  s->measured_by = o.by == "hand" ? MeasuredBy::hand : MeasuredBy::digitizer;
  if (o.blur_px) s->picture.blur_px = *o.blur_px;
  if (o.exposure) s->picture.exposure = *o.exposure;
  if (o.flash_us) s->picture.flash_s = 1e-6 * *o.flash_us;
  if (o.arrival_sd_ms) s->arrival_sd_s = 1e-3 * *o.arrival_sd_ms;
  return s;
}

/// A longer or shorter lens than the rig file's sees less or more.
Result<void> set_scale(const DesignOptions& options, RigFile& rig, SetUp& s) {
  if (options.distance_m.has_value() != options.pixel_um.has_value() ||
      (options.focal_mm && !options.distance_m))
    return fail("--distance-m and --pixel-um go together, and --focal-mm with them");
  if (options.distance_m) {
    const auto lens = through(s, {.pixel_pitch_um = *options.pixel_um,
                                  .focal_length_mm = options.focal_mm.value_or(0.0),
                                  .f_number = options.f_number,
                                  .distance_m = *options.distance_m});
    if (!lens) return tl::unexpected(lens.error());
    s = *lens;
  } else if (options.px_per_m && *options.px_per_m != s.px_per_m) {
    s = with_lens(s, *options.px_per_m / s.px_per_m);
  }
  rig.camera.px_per_m = s.px_per_m;
  return {};
}

Result<PlanFile> plan_of(const DesignOptions& options, const RigFile& rig) {
  PlanFile plan = rig.plan;
  if (!options.plan_path.empty()) {
    const auto text = read_option_file("--plan", options.plan_path);
    if (!text) return tl::unexpected(text.error());
    auto read = read_plan(*text, options.plan_path, plan);
    if (!read) return read;
    plan = std::move(*read);
  }
  if (!options.spacing.empty()) plan.spacing = options.spacing == "coded" ? Spacing::coded : Spacing::even;
  return plan;
}

}  // namespace

Result<DesignInputs> design_inputs(const DesignOptions& options) {
  auto rig = load_rig(options.rig_path);
  if (!rig) return tl::unexpected(rig.error());
  DesignInputs inputs;
  inputs.rig = std::move(*rig);
  if (options.px_per_m && !inputs.rig.camera.px_per_m) inputs.rig.camera.px_per_m = options.px_per_m;
  auto s = set_up(options, inputs.rig);
  if (!s) return tl::unexpected(s.error());
  inputs.design.set_up = std::move(*s);
  if (auto set = set_scale(options, inputs.rig, inputs.design.set_up); !set)
    return tl::unexpected(set.error());
  auto ball = expected_ball(options, inputs.rig);
  if (!ball) return tl::unexpected(ball.error());
  inputs.design.ball = *ball;
  const auto plan = plan_of(options, inputs.rig);
  if (!plan) return tl::unexpected(plan.error());
  if (const auto problem = plan_problem(plan->shot(), inputs.rig.limits))
    return fail(fmt::format("the plan's {}: {}", problem->field, problem->what));
  SpacedPlan spaced =
      spaced_plan(*plan, inputs.rig, inputs.design.set_up.measured_by == MeasuredBy::digitizer);
  if (!spaced.problem.empty()) return fail("the plan's " + spaced.problem);
  inputs.design.plan = std::move(spaced.plan);
  inputs.train_remark = std::move(spaced.remark);
  inputs.design.shots = options.shots;
  auto wanted = parse_wanted("--want", options.wanted, Percent::allowed);
  if (!wanted) return tl::unexpected(wanted.error());
  inputs.wanted = std::move(*wanted);
  auto differences = parse_wanted("--difference", options.differences, Percent::allowed);
  if (!differences) return tl::unexpected(differences.error());
  inputs.differences = std::move(*differences);
  inputs.power = options.power;
  inputs.search = options.search || options.most_images > 0 || !options.write_plan.empty();
  inputs.most_images = options.most_images;
  return inputs;
}

void add_design_options(CLI::App& command, DesignOptions& o) {
  command.add_option("--rig", o.rig_path, "rig file (default: the shipped example)");
  command.add_option("--plan", o.plan_path, "plan file (default: the rig file's [plan])");
  command.add_option("--spacing", o.spacing, "coded or even, of the train")
      ->check(CLI::IsMember({"coded", "even"}));
  command.add_option("--speed", o.speed_mps, "expected at touchdown, m/s");
  command.add_option("--angle", o.angle_deg, "expected angle against the surface, degrees, 1 to 90");
  command.add_option("--spin", o.spin_radps, "expected, rad/s; backspin positive (default: 0)");
  command.add_option("--e", o.e, "expected restitution (default: 0.75)");
  command.add_option("--mu", o.mu, "expected friction (default: 0.537)");
  command.add_option("--dwell-ms", o.dwell_ms, "expected, ms (default: 5)");
  command.add_option("--speed-sd", o.speed_sd_mps, "from ball to ball, m/s; as the next ones, 0 if left out");
  command.add_option("--angle-sd", o.angle_sd_deg, "from ball to ball, degrees");
  command.add_option("--spin-sd", o.spin_sd_radps, "from ball to ball, rad/s");
  command.add_option("--e-sd", o.e_sd, "from ball to ball");
  command.add_option("--mu-sd", o.mu_sd, "from ball to ball");
  command.add_option("--dwell-sd-ms", o.dwell_sd_ms, "from ball to ball, ms");
  command.add_option("--like", o.like, "balls as this session's shots, means and scatter");
  command.add_option("--scene", o.scene, "balls as this scene file's");
  command.add_option("--px-per-m", o.px_per_m, "another lens than the rig file's, on the same sensor");
  command.add_option("--scale-sd-percent", o.scale_sd_percent, "of the scale, in place of the calibration's");
  command
      .add_option("--focal-mm", o.focal_mm,
                  "of the lens (default: the longest usual one that sees 0.72 x 0.46 m)")
      ->excludes(command.get_option("--px-per-m"));
  command.add_option("--distance-m", o.distance_m,
                     "lens to the balls' plane; gives the scale, with --pixel-um");
  command.add_option("--pixel-um", o.pixel_um, "pitch of the sensor's pixels");
  command.add_option("--f-number", o.f_number, "of the lens")->capture_default_str();
  command.add_option("--by", o.by, "who measures the photographs: digitizer or hand")
      ->check(CLI::IsMember({"digitizer", "hand"}))
      ->capture_default_str();
  command.add_option("--blur-px", o.blur_px, "sd of the lens's blur (default: 0.8)");
  command.add_option("--exposure", o.exposure,
                     "1: an image's lightest felt is at 45 % of saturation (default: 1)");
  command.add_option("--flash-us", o.flash_us, "how long a flash lights (default: 1)");
  command.add_option(
      "--arrival-sd-ms", o.arrival_sd_ms,
      "of touchdown about the planned instant (default: the rig file's machine_lag_sd_ms, else 3)");
  command.add_option("--shots", o.shots, "of the series")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  command.add_option("--want", o.wanted, "half widths of the means' 95 % intervals, as e:0.005,omega_lo:1%")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--difference", o.differences, "between two series, to be found, as e:0.005,omega_lo:5")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--power", o.power, "probability that --difference is found")
      ->check(CLI::Range(kMinPower, kMaxPower))
      ->capture_default_str();
  command.add_flag("--best-train", o.search,
                   "search for the flashes that tell most, within the lamps' limits");
  command.add_option("--most-images", o.most_images, "likewise, with at most so many images of a leg")
      ->check(CLI::Range(2, 1000));
  command.add_option("--write-plan", o.write_plan, "likewise, and write that plan, for fire --plan");
  command.add_option("--figures", o.figures,
                     "folder for drawings: where images lie; U by balls, period, scale");
  command.add_flag("--all", o.all, "every quantity, and each whole budget");
  command.add_flag("--json", o.json, "one JSON object; nothing else on standard output");
  command_line::for_experts(command, {"--speed-sd",    "--angle-sd",    "--spin-sd",  "--mu-sd",
                                      "--dwell-sd-ms", "--dwell-ms",    "--scene",    "--focal-mm",
                                      "--distance-m",  "--pixel-um",    "--f-number", "--scale-sd-percent",
                                      "--blur-px",     "--exposure",    "--flash-us", "--arrival-sd-ms",
                                      "--power",       "--most-images", "--spacing",  "--all"});
}

}  // namespace strobe::host
