// The ball's course during contact: the damped sine pulse in both forms, on a rebound by rigid() or grip(),
// and the integrated mechanics, against the mechanics at the tightest tolerance.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "common/impact/closed_form/sine_pulse.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "tests/studies/trade/known_impacts.hpp"
#include "tests/studies/trade/stopwatch.hpp"
#include "tests/studies/trade/studies.hpp"

namespace strobe::studies::trade {

namespace {

using impact::ContactTrajectory;
using impact::PulseForm;

/// Contact images of a usual shot are one to three; four instants, the release included.
constexpr std::array kFractions{0.2, 0.45, 0.7, 1.0};
constexpr double kTightest = 1e-12;

struct Place {
  double x_m = 0.0, y_m = 0.0;
  double turned_m = 0.0;  ///< R phi
};
using Course = std::array<Place, kFractions.size()>;

impact::ContactOptions integrator(double tolerance) {
  return {.method = impact::ContactMethod::dormand_prince, .tolerance = tolerance};
}

struct KnownCourse {
  ImpactScene scene;
  Course course{};
};

Course by_ode(const ImpactScene& s, const impact::ContactOptions& options) {
  Course course;
  const auto contact = ContactTrajectory::make(s.ball, s.touchdown, s.contact, options);
  for (std::size_t i = 0; i < course.size(); ++i) {
    if (!contact) {
      course[i].x_m = NAN;
      continue;
    }
    const impact::ContactState state = contact->at(kFractions[i] * s.contact.dwell_s);
    course[i] = {state.x_m, state.y_m, s.ball.radius_m() * state.rotation_rad};
  }
  return course;
}

Course by_collocation(const ImpactScene& s, double tolerance) {
  Course course;
  const auto contact = impact::ContactCourse::make(
      s.ball, s.touchdown, s.contact, {.method = impact::ContactMethod::collocation, .tolerance = tolerance});
  for (std::size_t i = 0; i < course.size(); ++i) {
    if (!contact) {
      course[i].x_m = NAN;
      continue;
    }
    const impact::ContactMotion at = contact->at(kFractions[i] * s.contact.dwell_s);
    course[i] = {at.x_m, at.y_m, s.ball.radius_m() * at.rotation_rad};
  }
  return course;
}

Course by_pulse(const ImpactScene& s, PulseForm form, const Grip& grip) {
  Course course;
  course[0].x_m = NAN;
  const auto rebound = impact::grip(s.ball, s.touchdown, coefficients(s, grip));
  if (!rebound) return course;
  const auto pulse = impact::SinePulse::make(form, {.vx_td_mps = s.touchdown.vx_mps,
                                                    .vy_td_mps = s.touchdown.vy_mps,
                                                    .e = s.contact.e,
                                                    .impulse_ratio = rebound->impulse_ratio,
                                                    .dwell_s = s.contact.dwell_s,
                                                    .mass_kg = s.ball.mass_kg});
  if (!pulse) return course;
  const double rim = s.ball.radius_m() * s.touchdown.omega_radps;
  const double rim_change = s.ball.radius_m() * rebound->lift_off.omega_radps - rim;
  const double vy_change = rebound->lift_off.vy_mps - s.touchdown.vy_mps;
  for (std::size_t i = 0; i < course.size(); ++i) {
    const impact::PulseState state = pulse->at_fraction(kFractions[i]);
    const double time_s = kFractions[i] * s.contact.dwell_s;
    // Spin follows the impulse, of which the vertical path is the integral.
    const double share_s = (state.y_m - s.touchdown.vy_mps * time_s) / vy_change;
    course[i] = {state.x_m, state.y_m, rim * time_s + rim_change * share_s};
  }
  return course;
}

double difference(const ImpactScene& s, const Course& got, const Course& want) {
  double worst = 0.0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    const double d =
        std::hypot(got[i].x_m - want[i].x_m, got[i].y_m - want[i].y_m, got[i].turned_m - want[i].turned_m);
    if (!(d <= worst)) worst = d;
  }
  return worst / (s.speed_mps() * s.contact.dwell_s);
}

std::vector<KnownCourse> known(const std::vector<ImpactScene>& scenes) {
  std::vector<KnownCourse> all;
  for (const ImpactScene& s : scenes) all.push_back({s, by_ode(s, integrator(kTightest))});
  return all;
}

/// Rms of the largest difference in x, y and R phi each.
template <typename Follow>
std::string apart(const std::vector<KnownCourse>& set, const Follow& follow) {
  std::array<Tally, 3> tallies;
  for (const KnownCourse& k : set) {
    Course got = follow(k.scene);
    for (std::size_t part = 0; part < tallies.size(); ++part) {
      Course alone = k.course;
      for (std::size_t i = 0; i < alone.size(); ++i) {
        if (part == 0) alone[i].x_m = got[i].x_m;
        if (part == 1) alone[i].y_m = got[i].y_m;
        if (part == 2) alone[i].turned_m = got[i].turned_m;
      }
      tallies[part].add(difference(k.scene, alone, k.course));
    }
  }
  return fmt::format("rms of x {:.1e} y {:.1e} R phi {:.1e}", tallies[0].error().rms, tallies[1].error().rms,
                     tallies[2].error().rms);
}

template <typename Follow>
Error error_over(const std::vector<KnownCourse>& set, const Follow& follow) {
  Tally tally;
  for (const KnownCourse& k : set) tally.add(difference(k.scene, follow(k.scene), k.course));
  return tally.error();
}

}  // namespace

Study course_study(const Effort& effort) {
  const auto practical = known(practical_impacts(effort.scenes, effort.seed));
  const auto thesis = known(thesis_impacts());
  Study study{.name = "course",
              .title = "Place and rotation during contact",
              .what =
                  "at .2, .45, .7 and 1 of the dwell time, the set-up included; scenes as for lift_off; "
                  "norm: the largest |difference of (x, y, R phi)| over the way of the dwell time at the "
                  "speed of touchdown; reference: the mechanics at 1e-12",
              .unit = "of v_td*dwell"};
  // As far as lift-offs in 34 digits show it, the tightest tolerance is worth this much.
  study.reference = 2e-13;
  const auto add = [&](std::string method, std::string parameter, Source source, const auto& follow) {
    Row row{.method = std::move(method), .parameter = std::move(parameter), .source = source};
    row.practical = error_over(practical, follow);
    row.thesis = error_over(thesis, follow);
    row.cost_us = least_cost_us(effort.repetitions, practical.size(),
                                [&](std::size_t i) { keep(follow(practical[i].scene)); });
    if (source == Source::model) row.remark = apart(practical, follow);
    study.rows.push_back(row);
  };
  const Grip fitted{.e_x = impact::kFittedToThesis.e_x, .offset_m = impact::kFittedToThesis.offset_m};
  for (const bool grips : {false, true}) {
    const Grip grip = grips ? fitted : Grip{};
    for (const PulseForm form : {PulseForm::simplified, PulseForm::exact})
      add(fmt::format("pulse_{}", impact::name(form)), grips ? "rebound=grip_offset" : "rebound=rigid",
          Source::model, [=](const ImpactScene& s) { return by_pulse(s, form, grip); });
  }
  const std::vector<double> tolerances =
      effort.quick ? std::vector{1e-3, 1e-6} : std::vector{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10};
  for (const double tolerance : tolerances)
    add("collocation", fmt::format("tolerance={}", tolerance), Source::numerical,
        [=](const ImpactScene& s) { return by_collocation(s, tolerance); });
  for (const double tolerance : tolerances)
    add("ode", fmt::format("tolerance={}", tolerance), Source::numerical,
        [=](const ImpactScene& s) { return by_ode(s, integrator(tolerance)); });
  return study;
}

}  // namespace strobe::studies::trade
