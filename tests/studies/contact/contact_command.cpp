// strobe-bench contact: cost of a lift-off by collocation beside the integrator's at the same tolerance, in turns in one
// run, and its errors against 34 digits.
#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/impact/ode/contact_system.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/trade/impact_scenes.hpp"
#include "tests/studies/trade/known_impacts.hpp"
#include "tests/studies/trade/stopwatch.hpp"

namespace strobe::studies {

namespace {

using impact::ContactMethod;
using trade::ImpactScene;
using trade::KnownImpact;

struct Options {
  int contacts = 2000;
  int repetitions = 7;
  std::uint64_t seed = 1;
  bool json = false;
};

struct Result {
  double tolerance = 0.0;
  double integrator_us = 0.0, collocation_us = 0.0;
  double worst = 0.0;  ///< error over the tolerance
  int beyond = 0, taken_over = 0;
  double ratio() const { return integrator_us / collocation_us; }
};

impact::ContactOptions options_of(ContactMethod method, double tolerance) {
  return {.method = method, .tolerance = tolerance};
}

/// Of velocities and spin over the scale that the tolerance is relative to.
double error_of(const KnownImpact& known, const impact::Motion& got) {
  const ImpactScene& s = known.scene;
  const auto system = impact::detail::make_system(s.ball, s.touchdown, s.contact);
  const double speed = -s.touchdown.vy_mps, scale = system->tangential_scale() * speed;
  return std::max({std::abs(got.vy_mps - known.lift_off.vy_mps) / speed,
                   std::abs(got.vx_mps - known.lift_off.vx_mps) / scale,
                   s.ball.radius_m() * std::abs(got.omega_radps - known.lift_off.omega_radps) / scale});
}

void judge(const std::vector<KnownImpact>& known, Result& result) {
  for (const KnownImpact& k : known) {
    const auto got = impact::lift_off(k.scene.ball, k.scene.touchdown, k.scene.contact,
                                      options_of(ContactMethod::collocation, result.tolerance));
    const double error = got ? error_of(k, got->lift_off) / result.tolerance : HUGE_VAL;
    result.worst = std::max(result.worst, error);
    if (error > 1.0) ++result.beyond;
    if (got && got->method != ContactMethod::collocation) ++result.taken_over;
  }
}

/// Microseconds of a stretch of contacts by one method, the least of the repetitions kept.
void time_stretch(const std::vector<KnownImpact>& known, std::size_t first, std::size_t last,
                  const Options& options, Result& result) {
  std::array<double, 2> least{HUGE_VAL, HUGE_VAL};
  for (int r = 0; r < options.repetitions; ++r) {
    for (std::size_t m = 0; m < 2; ++m) {
      const auto asked =
          options_of(m == 0 ? ContactMethod::dormand_prince : ContactMethod::collocation, result.tolerance);
      const double us = trade::stretch_us(first, last, 1, [&](std::size_t i) {
        const ImpactScene& s = known[i].scene;
        trade::keep(impact::lift_off(s.ball, s.touchdown, s.contact, asked));
      });
      least[m] = std::min(least[m], us);
    }
  }
  result.integrator_us += least[0] / static_cast<double>(known.size());
  result.collocation_us += least[1] / static_cast<double>(known.size());
}

void print(const Result& r, bool json) {
  if (json) {
    const nlohmann::json line{{"tolerance", r.tolerance},
                              {"integrator_us", r.integrator_us},
                              {"collocation_us", r.collocation_us},
                              {"cost_ratio", r.ratio()},
                              {"worst_error_of_tolerance", r.worst},
                              {"beyond_tolerance", r.beyond},
                              {"taken_over", r.taken_over}};
    std::printf("%s\n", line.dump().c_str());
    return;
  }
  std::printf("%9.0e %10.2f us %10.3f us %8.2f %10.3f %8d %8d\n", r.tolerance, r.integrator_us,
              r.collocation_us, r.ratio(), r.worst, r.beyond, r.taken_over);
}

int run(const Options& options) {
  const auto known = trade::known_impacts(trade::practical_impacts(options.contacts, options.seed));
  if (!options.json)
    std::printf("%d contacts (%s), seed %llu; errors against 34 digits\n%9s %13s %13s %8s %10s %8s %8s\n",
                options.contacts, trade::kPracticalRange, static_cast<unsigned long long>(options.seed),
                "tolerance", "integrator", "collocation", "ratio", "worst/tol", "beyond", "taken");
  bool kept = true;
  for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-12}) {
    Result result{.tolerance = tolerance};
    constexpr std::size_t kStretch = 50;
    for (std::size_t first = 0; first < known.size(); first += kStretch)
      time_stretch(known, first, std::min(first + kStretch, known.size()), options, result);
    judge(known, result);
    print(result, options.json);
    kept = kept && result.beyond == 0;
  }
  return kept ? 0 : 1;
}

}  // namespace

void add_contact_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("contact",
                                         "cost of a lift-off by collocation beside the integrator's, in "
                                         "turns, and its errors against 34 digits\nExample: "
                                         "strobe-bench contact --contacts 200");
  command->add_option("--contacts", options->contacts, "contacts drawn over the practical range")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command
      ->add_option("--repetitions", options->repetitions, "timings of a stretch, the least of which counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "of the draws")->capture_default_str();
  command->add_flag("--json", options->json, "one JSON object per tolerance, nothing else on stdout");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace strobe::studies
