// Impact models against the contact's mechanics.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/impact/closed_form/sine_pulse.hpp"
#include "tests/studies/trade/known_impacts.hpp"
#include "tests/studies/trade/stopwatch.hpp"
#include "tests/studies/trade/studies.hpp"

namespace strobe::studies::trade {

namespace {

using namespace impact;

struct Sets {
  std::vector<KnownImpact> practical;
  std::vector<KnownImpact> thesis;
};

/// Errors of what `predict` (of an index into the set and its scene) gives, none if it fails.
template <typename Predict>
Error error_over(const std::vector<KnownImpact>& set, const Predict& predict) {
  Tally tally;
  for (const KnownImpact& k : set) {
    const std::optional<Motion> got = predict(k.scene);
    tally.add(got ? lift_off_error(k.scene, *got, k.lift_off) : 1.0);
  }
  return tally.error();
}

template <typename Predict>
Row measured(const Sets& sets, const Effort& effort, std::string method, std::string parameter, Source source,
             const Predict& predict) {
  Row row{.method = std::move(method), .parameter = std::move(parameter), .source = source};
  row.practical = error_over(sets.practical, predict);
  row.thesis = error_over(sets.thesis, predict);
  row.cost_us = least_cost_us(effort.repetitions, sets.practical.size(),
                              [&](std::size_t i) { keep(predict(sets.practical[i].scene)); });
  return row;
}

std::optional<Motion> by_ode(const ImpactScene& s, const ContactOptions& options) {
  const auto summary = impact::simulate(s.ball, s.touchdown, s.contact, options);
  return summary ? std::optional(summary->lift_off) : std::nullopt;
}

std::optional<Motion> by_collocation(const ImpactScene& s, double tolerance) {
  const auto end = impact::lift_off(s.ball, s.touchdown, s.contact,
                                    {.method = ContactMethod::collocation, .tolerance = tolerance});
  return end ? std::optional(end->lift_off) : std::nullopt;
}

std::optional<Motion> by_grip(const ImpactScene& s, const Grip& grip) {
  const auto rebound = impact::grip(s.ball, s.touchdown, coefficients(s, grip));
  return rebound ? std::optional(rebound->lift_off) : std::nullopt;
}

void add_closed_forms(Study& study, const Sets& sets, const Effort& effort) {
  study.rows.push_back(
      measured(sets, effort, "rigid", "", Source::model, [](const ImpactScene& s) -> std::optional<Motion> {
        const auto r = impact::rigid(s.ball, s.touchdown, s.contact.e, s.contact.mu);
        return r ? std::optional(r->lift_off) : std::nullopt;
      }));
  for (const PulseForm form : {PulseForm::simplified, PulseForm::exact}) {
    study.rows.push_back(measured(sets, effort, fmt::format("pulse_{}", impact::name(form)), "",
                                  Source::model, [form](const ImpactScene& s) -> std::optional<Motion> {
                                    const auto r =
                                        impact::pulse_rebound(form, s.ball, s.touchdown, s.contact.e,
                                                              s.contact.mu, s.contact.dwell_s);
                                    return r ? std::optional(r->rebound.lift_off) : std::nullopt;
                                  }));
    study.rows.back().remark = "gives the force's course as well";
  }
}

void add_grips(Study& study, const Sets& sets, const Effort& effort) {
  // Calibrated on other draws than those it is judged by.
  const auto others = known_impacts(practical_impacts(effort.quick ? 6 : 100, effort.seed + 1));
  for (const bool offset : {false, true}) {
    Grip grip = calibrated_over(others, offset);
    grip.e_x = std::round(grip.e_x * 1e3) / 1e3;
    grip.offset_m = std::round(grip.offset_m * 1e5) / 1e5;
    // Programs that take the row run it with these constants.
    std::string constants = fmt::format("ex={:.3f}", grip.e_x);
    if (offset) constants += fmt::format(";offset_mm={:.2f}", grip.offset_m * 1e3);
    study.rows.push_back(measured(sets, effort, offset ? "grip_offset" : "grip", constants, Source::model,
                                  [grip](const ImpactScene& s) { return by_grip(s, grip); }));
  }
}

/// How often the integrator had to take over, as the row's remark.
std::string taken_over(const std::vector<KnownImpact>& set, double tolerance) {
  const auto by_integrator = [&](const KnownImpact& k) {
    const auto end = impact::lift_off(k.scene.ball, k.scene.touchdown, k.scene.contact,
                                      {.method = ContactMethod::collocation, .tolerance = tolerance});
    return !end || end->method != ContactMethod::collocation;
  };
  return fmt::format("the integrator took over in {} of {}", std::ranges::count_if(set, by_integrator),
                     set.size());
}

void add_quick_solutions(Study& study, const Sets& sets, const Effort& effort) {
  for (int power = 3; power <= 12; power += effort.quick ? 3 : 1) {
    const double tolerance = std::stod(fmt::format("1e-{}", power));
    study.rows.push_back(
        measured(sets, effort, "collocation", fmt::format("tolerance={}", tolerance), Source::numerical,
                 [tolerance](const ImpactScene& s) { return by_collocation(s, tolerance); }));
    study.rows.back().remark = taken_over(sets.practical, tolerance);
  }
}

void add_integrations(Study& study, const Sets& sets, const Effort& effort) {
  for (int power = 3; power <= 12; power += effort.quick ? 3 : 1) {
    const double tolerance = std::stod(fmt::format("1e-{}", power));
    const ContactOptions options{.method = ContactMethod::dormand_prince, .tolerance = tolerance};
    study.rows.push_back(measured(sets, effort, "ode", fmt::format("tolerance={}", tolerance),
                                  Source::numerical,
                                  [options](const ImpactScene& s) { return by_ode(s, options); }));
  }
}

/// Every scene's shots beside the grip calibrated at its mean.
struct Spread {
  std::vector<KnownImpact> shots;
  std::vector<Grip> grips;  ///< of each shot's scene
};

Spread spread_of(const std::vector<ImpactScene>& scenes, const Effort& effort) {
  constexpr int kShots = 5;
  Spread spread;
  std::vector<ImpactScene> shots;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Grip grip = calibrated_at(scenes[i]);
    for (const ImpactScene& shot : shots_of(scenes[i], kShots, effort.seed + 1000 + i)) {
      shots.push_back(shot);
      spread.grips.push_back(grip);
    }
  }
  spread.shots = known_impacts(shots);
  return spread;
}

Error error_of_grips(const Spread& spread) {
  Tally tally;
  for (std::size_t i = 0; i < spread.shots.size(); ++i) {
    const KnownImpact& k = spread.shots[i];
    const auto got = by_grip(k.scene, spread.grips[i]);
    tally.add(got ? lift_off_error(k.scene, *got, k.lift_off) : 1.0);
  }
  return tally.error();
}

Study within_a_scene(const std::vector<ImpactScene>& practical, const std::vector<ImpactScene>& thesis,
                     const Effort& effort) {
  Study study{.name = "lift_off_scene",
              .title = "Lift-off within the spread of one scene",
              .what =
                  "shots about each scene (speed 2 %, angle 0.6 deg, spin 10 rad/s, e .01, mu .03, dwell "
                  "1.5 %); norm and reference as for lift_off",
              .unit = "of v_td"};
  const auto few = [&](const std::vector<ImpactScene>& all) {
    const std::size_t most = effort.quick ? 1 : 60;
    return std::vector<ImpactScene>(all.begin(),
                                    all.begin() + static_cast<std::ptrdiff_t>(std::min(most, all.size())));
  };
  const Spread of_practical = spread_of(few(practical), effort);
  const Spread of_thesis = spread_of(few(thesis), effort);
  const Sets sets{of_practical.shots, of_thesis.shots};
  study.rows.push_back(measured(sets, effort, "rigid", "", Source::model,
                                [](const ImpactScene& s) { return by_grip(s, Grip{}); }));
  Row grip{.method = "grip_offset", .parameter = "calibrated=scene", .source = Source::model};
  grip.practical = error_of_grips(of_practical);
  grip.thesis = error_of_grips(of_thesis);
  grip.cost_us = least_cost_us(effort.repetitions, sets.practical.size(), [&](std::size_t i) {
    keep(by_grip(sets.practical[i].scene, of_practical.grips[i]));
  });
  grip.remark = "besides one ODE run a scene";
  study.rows.push_back(grip);
  for (const double tolerance : {1e-3, 1e-6, 1e-9})
    study.rows.push_back(
        measured(sets, effort, "collocation", fmt::format("tolerance={}", tolerance), Source::numerical,
                 [tolerance](const ImpactScene& s) { return by_collocation(s, tolerance); }));
  for (const double tolerance : {1e-3, 1e-6})
    study.rows.push_back(measured(sets, effort, "ode", fmt::format("tolerance={}", tolerance),
                                  Source::numerical, [tolerance](const ImpactScene& s) {
                                    return by_ode(
                                        s, {.method = ContactMethod::dormand_prince, .tolerance = tolerance});
                                  }));
  return study;
}

}  // namespace

std::vector<Study> lift_off_studies(const Effort& effort) {
  const auto practical = practical_impacts(effort.scenes, effort.seed);
  auto thesis = thesis_impacts();
  if (effort.quick) thesis.resize(2);
  const Sets sets{known_impacts(practical), known_impacts(thesis)};
  Study study{.name = "lift_off",
              .title = "Velocities and spin at lift-off",
              .what = fmt::format("{} scenes: {}; norm: |difference of (vx, vy, R omega)| over the speed of "
                                  "touchdown; reference: the contact's mechanics in 34 digits",
                                  practical.size(), kPracticalRange),
              .unit = "of v_td"};
  study.reference = reference_error(practical, effort.quick ? 1 : 40);
  add_closed_forms(study, sets, effort);
  add_grips(study, sets, effort);
  add_quick_solutions(study, sets, effort);
  add_integrations(study, sets, effort);
  Study scene = within_a_scene(practical, thesis, effort);
  scene.reference = study.reference;
  return {study, scene};
}

}  // namespace strobe::studies::trade
