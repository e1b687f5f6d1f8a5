// General engines on the same bounces, each against what is exact for its own law of contact.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "common/impact/closed_form/rebound.hpp"
#include "tests/studies/trade/engines/engine.hpp"
#include "tests/studies/trade/known_impacts.hpp"
#include "tests/studies/trade/stopwatch.hpp"
#include "tests/studies/trade/studies.hpp"

namespace strobe::studies::trade {

std::vector<double> falling(double coarse, double fine) {
  std::vector<double> all;
  for (double decade = coarse; decade > 0.9 * fine; decade *= 0.1)
    for (const double part : {1.0, 0.5, 0.2})
      if (decade * part > 0.9 * fine) all.push_back(std::stod(fmt::format("{:.0e}", decade * part)));
  return all;
}

namespace {

constexpr std::array kPhases{0.1, 0.5, 0.9};

EngineBounce bounce_of(const ImpactScene& s) {
  return {s.ball, s.touchdown, s.contact.e, s.contact.mu, s.contact.dwell_s};
}

std::vector<EngineBounce> bounces_of(const std::vector<ImpactScene>& scenes, const EngineSetting& setting) {
  std::vector<EngineBounce> all;
  for (const ImpactScene& s : scenes) {
    all.push_back(bounce_of(s));
    if (setting.law == EngineLaw::hertz) all.back().hertz = hertz_contact(all.back(), setting.transition_mps);
  }
  return all;
}

/// rigid() in long double: slides, or rolls if friction suffices.
impact::Motion exact_rigid(const EngineBounce& b) {
  using Real = long double;
  const Real alpha = b.ball.alpha, radius = Real(b.ball.diameter_m) / 2;
  const Real spin = radius * Real(b.touchdown.omega_radps);
  const Real slip = Real(b.touchdown.vx_mps) + spin;
  const Real limit = Real(b.mu) * (1 + Real(b.e)) * -Real(b.touchdown.vy_mps);
  const Real dvx = std::clamp(-slip * alpha / (1 + alpha), -limit, limit);
  return {static_cast<double>(b.touchdown.vx_mps + dvx), static_cast<double>(-Real(b.e) * b.touchdown.vy_mps),
          static_cast<double>((spin + dvx / alpha) / radius)};
}

/// What is exact for a law. With half as many steps hertz_lift_off() changes by less than 1e-9 of the speed:
/// friction's kink at the transition is what costs digits.
impact::Motion exact_of(EngineLaw law, const EngineBounce& b) {
  return law == EngineLaw::hertz ? hertz_lift_off(b, 20000) : exact_rigid(b);
}

struct Measured {
  Tally tally;
  double us = 0.0, simulated_s = 0.0;
  int runs = 0;
  int lost = 0;  ///< the ball did not leave
};

/// Scenes as an engine sees them, with what is exact.
struct Bounces {
  std::vector<ImpactScene> scenes;
  std::vector<EngineBounce> bounces;
  std::vector<impact::Motion> exact;
};

Bounces bounces_for(const EngineSetting& setting, const std::vector<ImpactScene>& scenes) {
  Bounces all{scenes, bounces_of(scenes, setting), {}};
  for (const EngineBounce& b : all.bounces) all.exact.push_back(exact_of(setting.law, b));
  return all;
}

Measured over(Engine& engine, const EngineSetting& setting, double value, const Bounces& all,
              int repetitions) {
  Measured m;
  for (std::size_t i = 0; i < all.scenes.size(); ++i) {
    const EngineBounce& b = all.bounces[i];
    for (const double phase : kPhases) {
      // A law without a step to begin in is started at the surface, once.
      if (setting.control != "step_s" && phase != kPhases.front()) continue;
      EngineRun run;
      double least_us = std::numeric_limits<double>::infinity();
      double spent_us = 0.0;
      for (int k = 0; k < repetitions && (k == 0 || spent_us < 20e3); ++k) {
        run = engine.bounce(setting, value, b, phase);
        least_us = std::min(least_us, run.contact_us);
        spent_us += run.contact_us;
      }
      ++m.runs;
      if (!run.left) {
        ++m.lost;
        continue;
      }
      m.tally.add(lift_off_error(all.scenes[i], run.lift_off, all.exact[i]));
      m.us += least_us;
      m.simulated_s += run.simulated_s;
    }
  }
  return m;
}

std::string remark_of(const Measured& m) {
  std::string text = fmt::format("{:.2g} us a simulated ms", m.us / (m.simulated_s * 1e3));
  if (m.lost > 0) text += fmt::format("; the ball stays down in {} of {} runs", m.lost, m.runs);
  return text;
}

void add_engine(Study& study, Engine& engine, const std::vector<ImpactScene>& practical,
                const std::vector<ImpactScene>& thesis, const Effort& effort) {
  for (EngineSetting& setting : engine.settings()) {
    const Bounces of_practical = bounces_for(setting, practical);
    const Bounces of_thesis = bounces_for(setting, thesis);
    if (effort.quick) setting.values = {setting.values[setting.values.size() / 3]};
    for (const double value : setting.values) {
      const Measured p = over(engine, setting, value, of_practical, effort.repetitions);
      const Measured t = over(engine, setting, value, of_thesis, 1);
      if (p.lost == p.runs) continue;
      Row row{.method = engine.name() + ", " + setting.name,
              .parameter = fmt::format("{}={}", setting.control, value),
              .cost_us = p.us / (p.runs - p.lost),
              .practical = p.tally.error(),
              .thesis = t.tally.error(),
              .source = Source::numerical,
              .remark = remark_of(p)};
      row.general = true;
      study.rows.push_back(row);
    }
  }
}

/// The product's own methods on the same bounces: the closed form for the rigid law and for spring and
/// dashpot, the integrated mechanics (with a tangential spring, which no engine has) for its own.
void add_own(Study& study, std::vector<ImpactScene> practical, std::vector<ImpactScene> thesis,
             const Effort& effort) {
  Row rigid{.method = "rigid", .parameter = "", .source = Source::numerical};
  const auto error_over = [](const std::vector<ImpactScene>& scenes) {
    Tally tally;
    for (const ImpactScene& s : scenes)
      tally.add(lift_off_error(s, impact::rigid(s.ball, s.touchdown, s.contact.e, s.contact.mu)->lift_off,
                               exact_rigid(bounce_of(s))));
    return tally.error();
  };
  rigid.practical = error_over(practical);
  rigid.thesis = error_over(thesis);
  rigid.cost_us = least_cost_us(effort.repetitions, practical.size(), [&](std::size_t i) {
    const ImpactScene& s = practical[i];
    keep(impact::rigid(s.ball, s.touchdown, s.contact.e, s.contact.mu));
  });
  study.rows.push_back(rigid);
  for (auto* scenes : {&practical, &thesis})
    for (ImpactScene& s : *scenes) s.contact.offset_share = 0.0;
  const auto known_practical = known_impacts(practical);
  const auto known_thesis = known_impacts(thesis);
  const auto add = [&](const char* method, const std::string& parameter, const auto& lift_off) {
    Row row{.method = method, .parameter = parameter, .source = Source::numerical};
    const auto over_all = [&](const std::vector<KnownImpact>& known) {
      Tally tally;
      for (const KnownImpact& k : known) tally.add(lift_off_error(k.scene, lift_off(k.scene), k.lift_off));
      return tally.error();
    };
    row.practical = over_all(known_practical);
    row.thesis = over_all(known_thesis);
    row.cost_us = least_cost_us(effort.repetitions, practical.size(),
                                [&](std::size_t i) { keep(lift_off(practical[i])); });
    row.remark = "with tangential compliance";
    study.rows.push_back(row);
  };
  const auto integrated = [](const impact::ContactOptions& options) {
    return [options](const ImpactScene& s) {
      return impact::simulate(s.ball, s.touchdown, s.contact, options)->lift_off;
    };
  };
  for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-12})
    add("collocation", fmt::format("tolerance={}", tolerance), [tolerance](const ImpactScene& s) {
      return impact::lift_off(s.ball, s.touchdown, s.contact,
                              {.method = impact::ContactMethod::collocation, .tolerance = tolerance})
          ->lift_off;
    });
  for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-12})
    add("ode", fmt::format("tolerance={}", tolerance),
        integrated({.method = impact::ContactMethod::dormand_prince, .tolerance = tolerance}));
}

}  // namespace

Study engine_study(const Effort& effort, std::vector<std::string>& missing) {
  auto practical = practical_impacts(effort.quick ? 1 : 20, effort.seed + 3);
  auto thesis = thesis_impacts();
  if (effort.quick) thesis.resize(1);
  Study study{
      .name = "engines",
      .title = "General engines on the same bounces",
      .what = fmt::format(
          "{} scenes of the practical range and the 21 conditions, 3 phases of the touchdown within a "
          "step; same ball, e, mu, dwell time (spring and dashpot from them), no gravity; cost: the "
          "engine's steps from touchdown to lift-off; norm as for lift_off, against what is exact for "
          "the engine's own law",
          practical.size()),
      .unit = "of v_td"};
  add_own(study, practical, thesis, effort);
  const auto try_engine = [&](const char* name, const std::unique_ptr<Engine>& engine) {
    if (engine)
      add_engine(study, *engine, practical, thesis, effort);
    else
      missing.emplace_back(name);
  };
  try_engine("Bullet", make_bullet());
  try_engine("ODE", make_open_dynamics());
  try_engine("Simbody", make_simbody());
  return study;
}

}  // namespace strobe::studies::trade
