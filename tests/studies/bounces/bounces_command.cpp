// strobe-bench bounces: what the atlas of bounces (`strobe bounces`) cannot hold. The elastic ball's closed form beside a
// numerical solution of its whole footprint, by angle and on the alumina spheres that others measured; with --spindoe,
// predictions of table-tennis bounces whose data are not ours to copy.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "common/config/files.hpp"
#include "common/impact/closed_form/elastic_rebound.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/bounces/spindoe.hpp"
#include "tests/support/elastic_footprint.hpp"

namespace strobe::studies {

namespace {

using bounces::Case;
using bounces::Model;

struct Options {
  int springs = 200;
  std::string spindoe, data;
};

constexpr ball::Ball kSphere{.diameter_m = 0.005, .mass_kg = 2.6e-4, .alpha = 0.4};

double whole(double slip, double mu, double kappa, int springs) {
  return testing::footprint_slip_lo({.slip = slip, .mu = mu, .kappa = kappa}, springs, 10 * springs);
}

/// psi2 of both by psi1, in units of mu·|vy|/kappa; and the largest difference of vx.
void compare_footprint(int springs) {
  fmt::print("elastic sphere, e 1: psi2 = kappa·slip_LO/(mu·|vy|) by the closed form less that of the whole footprint\n");
  fmt::print("{:>6}", "psi1");
  const std::array ratios{0.0, 0.23, 0.3, 0.5};
  for (const double nu : ratios) fmt::print("   nu {:<4} {:>8}", nu, "less");
  fmt::print("\n");
  std::array<double, 4> worst{};
  for (double psi = 0.25; psi < 7.0; psi += 0.25) {
    fmt::print("{:>6.2f}", psi);
    for (std::size_t i = 0; i < ratios.size(); ++i) {
      const double kappa = impact::mindlin_stiffness_ratio(ratios[i]), mu = 0.1, slip = psi * mu / kappa;
      const auto lumped = impact::elastic_rebound(kSphere, {slip, -1.0, 0.0}, {.mu = mu, .stiffness_ratio = kappa});
      const double difference = lumped->slip_lo_mps - whole(slip, mu, kappa, springs);
      worst[i] = std::max(worst[i], std::abs(difference) / 3.5 / mu);
      fmt::print("{:>9.3f} {:>8.3f}", kappa * lumped->slip_lo_mps / mu, kappa * difference / mu);
    }
    fmt::print("\n");
  }
  fmt::print("largest difference of vx, of mu·|vy|:");
  for (const double w : worst) fmt::print(" {:.3f}", w);
  fmt::print("\n");
}

struct Tally {
  int count = 0, within = 0;
  double square = 0.0, z_square = 0.0;
  std::vector<double> sizes{};

  double median() {
    if (sizes.empty()) return 0.0;
    std::ranges::nth_element(sizes, sizes.begin() + count / 2);
    return sizes[static_cast<std::size_t>(count / 2)];
  }
  void add(double residual, double sd) {
    ++count;
    sizes.push_back(std::abs(residual));
    within += std::abs(residual) <= 1.96 * sd ? 1 : 0;
    square += residual * residual;
    z_square += std::pow(residual / sd, 2);
  }
  std::string text() {
    return fmt::format("{:>5}{:>7.0f} %{:>9.3f}{:>10.3f}{:>8.2f}", count, 100.0 * within / std::max(count, 1), median(),
                       std::sqrt(square / std::max(count, 1)), std::sqrt(z_square / std::max(count, 1)));
  }
};

/// The atlas's alumina spheres by the whole footprint, with the sds that the closed form's residuals have.
Result<void> alumina(const std::string& data, int springs) {
  const auto all = published::load_bounces(data);
  if (!all) return tl::unexpected(all.error());
  const published::Set* set = all->set("kharaz_2001");
  if (set == nullptr) return fail(data + ": no set kharaz_2001");
  Tally lumped[2], footprint[2];
  for (const Case& c : bounces::cases_of(*all, *set)) {
    const auto p = bounces::predict(c, Model::elastic);
    if (!p) return tl::unexpected(p.error());
    const double kappa = impact::mindlin_stiffness_ratio(*c.ball.poisson_ratio), beta = 1.0 + 1.0 / c.ball.alpha.value;
    const double approach = -c.bounce.vy_td_mps.value, radius = c.ball.diameter_m / 2.0, e = *c.bounce.restitution();
    const double slip = c.bounce.vx_td_mps.value / approach;
    // The footprint's solution is for e = 1. A contact that loses energy has (1 + e)/2 of the impulse.
    const double change = (whole(slip, c.mu(), kappa, springs) - slip) * approach / beta * (1.0 + e) / 2.0;
    const double vx = c.bounce.vx_td_mps.value + change, omega = change / (c.ball.alpha.value * radius);
    if (p->residual.vx_mps && !p->vx_is_given) {
      lumped[0].add(p->residual.vx_mps->value, p->residual.vx_mps->sd);
      footprint[0].add(vx - c.bounce.vx_lo_mps->value, p->residual.vx_mps->sd);
    }
    if (p->residual.omega_radps) {
      lumped[1].add(p->residual.omega_radps->value, p->residual.omega_radps->sd);
      footprint[1].add(omega - c.bounce.omega_lo_radps->value, p->residual.omega_radps->sd);
    }
  }
  fmt::print("\nalumina spheres (kharaz_2001)\n{:<28}{:>5}{:>9}{:>9}{:>10}{:>8}\n", "", "n", "95 %", "median", "rms", "rms z");
  for (const int i : {0, 1}) {
    fmt::print("{:<28}{}\n", i == 0 ? "vx m/s, closed form" : "omega rad/s, closed form", lumped[i].text());
    fmt::print("{:<28}{}\n", i == 0 ? "vx m/s, whole footprint" : "omega rad/s, whole footprint", footprint[i].text());
  }
  return {};
}

/// With the share of the friction's own scatter: it is one number for all tables and balls.
Result<Tally> tally_of(const std::vector<Case>& cases, Model model, bool grips) {
  Tally out;
  for (Case c : cases) {
    const auto p = bounces::predict(c, model);
    if (!p) return tl::unexpected(p.error());
    const double impulse = c.bounce.vy_lo_mps->value - c.bounce.vy_td_mps.value;
    const double slip = c.bounce.vx_td_mps.value + c.ball.diameter_m / 2.0 * c.bounce.omega_td_radps.value;
    if ((c.mu() * impulse > 0.4 * slip) != grips) continue;
    double by_friction = 0.0;
    const published::Measured mu = *c.friction.elsewhere;
    for (const int way : {-1, 1}) {
      c.friction.mu = c.friction.elsewhere->value = mu.value + way * mu.sd;
      const auto moved = bounces::predict(c, model);
      if (!moved) return tl::unexpected(moved.error());
      by_friction += way * moved->lift_off.vx_mps / 2.0;
    }
    out.add(p->residual.vx_mps->value,
            model == Model::known ? p->residual.vx_mps->sd : std::hypot(p->residual.vx_mps->sd, by_friction));
  }
  return out;
}

void print_in_space(const std::vector<SpatialBounce>& bounces) {
  for (const bool with_across : {true, false}) {
    fmt::print("in space, {}; each half of the flights by coefficients fitted to the other\n{:<16}{:>5}{:>9}{:>9}{:>9}{:>8}   mu, e_x or "
               "kt/k (even; odd flights)\n",
               with_across ? "all bounces" : "those whose velocity changes along the slip", "model", "n", "vx rms", "vz rms", "median",
               "95 %");
    for (const SpatialTally& t : judged_in_space(bounces, with_across))
      fmt::print("{:<16}{:>5}{:>9.3f}{:>9.3f}{:>9.3f}{:>6.0f} %   {:.3f} {:.2f}; {:.3f} {:.2f}\n",
                 t.model + (t.in_space ? "" : ", plane"), t.count, t.vx_rms_mps, t.vz_rms_mps, t.median_mps, 100.0 * t.within,
                 t.even[0], t.even[1], t.odd[0], t.odd[1]);
  }
}

Result<void> table_tennis(const std::string& folder) {
  const auto flights = read_spindoe(folder);
  if (!flights) return tl::unexpected(flights.error());
  const Judged judged = judged_by(*flights);
  fmt::print("\ntable tennis (SpinDOE): {} flights, {} without a bounce, {} implausible, {} with a change across the slip; {} tell the friction, {} are judged\n",
             flights->flights, flights->without_bounce, flights->implausible, flights->across, judged.telling, judged.cases.size());
  if (judged.cases.empty()) return fail(folder + ": no bounces");
  fmt::print("mu {:.3f} ± {:.3f} (one bounce); change of velocity across the slip, rms over the impulse: {:.3f}, "
             "with the stored sign of the spin's y {:.3f}\n",
             judged.mu, judged.cases.front().friction.elsewhere->sd, judged.across_rms, judged.across_as_stored_rms);
  fmt::print("speed along the slip after the bounce, m/s\n{:<12}{:>5}{:>9}{:>9}{:>10}{:>8}{:>9}{:>9}{:>9}{:>10}{:>8}  valid\n", "model",
             "grip", "95 %", "median", "rms", "rms z", "slide", "95 %", "median", "rms", "rms z");
  for (const Model model : bounces::kModels) {
    auto grips = tally_of(judged.cases, model, true), slides = tally_of(judged.cases, model, false);
    if (!grips) return tl::unexpected(grips.error());
    if (!slides) return tl::unexpected(slides.error());
    const bool tennis = model == Model::grip || model == Model::mechanics || model == Model::known;
    const std::string_view against =
        tennis ? "constants of a tennis ball" : bounces::not_valid(judged.cases.front(), model);
    fmt::print("{:<12}{}    {}  {}\n", bounces::name(model), grips->text(), slides->text(),
               against.empty() ? "yes" : fmt::format("no: {}", against));
  }
  print_in_space(flights->in_space);
  return {};
}

int run(const Options& options) {
  compare_footprint(options.springs);
  auto data = options.data.empty() ? config::share_folder().map([](const auto& s) { return (s / "bounces").string(); })
                                   : Result<std::string>(options.data);
  Result<void> done = data ? alumina(*data, options.springs) : Result<void>(tl::unexpected(data.error()));
  if (done && !options.spindoe.empty()) done = table_tennis(options.spindoe);
  if (!done) fmt::print(stderr, "strobe-bench: bounces: {}\n", done.error().message);
  return done ? 0 : 2;
}

}  // namespace

void add_bounces_study_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "bounces", "The elastic ball's closed form against its whole footprint; table-tennis bounces of SpinDOE.");
  command->add_option("--springs", options->springs, "Of the footprint's foundation")->check(CLI::Range(10, 5000));
  command->add_option("--data", options->data, "Folder of bounces (default: the shipped ones)");
  command->add_option("--spindoe", options->spindoe, "Folder with SpinDOE's unpacked trajectories");
  command->footer("Example: strobe-bench bounces --spindoe trajectories");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::studies
