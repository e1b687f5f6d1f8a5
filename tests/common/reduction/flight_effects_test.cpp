// Drag and Magnus lift in the best estimator: what they change, and when they are left out.
#include <cmath>
#include <string>

#include "common/reduction/flight_effects.hpp"
#include "common/reduction/reduce.hpp"
#include "common/units/angles.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using test::Bounce;
using test::Setup;

namespace {

Frame photograph(const Bounce& bounce, const Setup& setup, std::uint64_t seed = 5) {
  test::Random random(seed);
  return test::photograph(bounce, setup, random);
}

Readout reduced(const Frame& frame, const ReduceOptions& options = {}) {
  const auto readout = reduce(frame, Estimator::best, options);
  if (!readout) FAIL(readout.error().message.c_str());
  return *readout;
}

Setup exact() {
  Setup setup;
  setup.noise_factor = 0.0;
  return setup;
}

}  // namespace

TEST_GROUP(FlightEffects){};

TEST(FlightEffects, WithoutNoiseTheTruthIsReadToAThousandthOfAnSd) {
  // The photographs' air is integrated, the estimator's a series; truth and estimator share C_D.
  for (const Bounce& bounce : test::thesis_bounces()) {
    const Readout r = reduced(photograph(bounce, exact()));
    const Quantities truth = test::truth(bounce);
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      if (!truth[q]) continue;
      const std::string text = bounce.label + " " + std::string(name(q)) + " " +
                               std::to_string((*r.value[q] - *truth[q]) / *r.sd[q]);
      CHECK_TRUE_TEXT(std::abs(*r.value[q] - *truth[q]) < 1e-3 * *r.sd[q], text.c_str());
    }
  }
}

TEST(FlightEffects, LeavingThemOutChangesNoNumberByMoreThanItsBound) {
  for (const Bounce& bounce : test::thesis_bounces()) {
    const Frame frame = photograph(bounce, exact());
    FlagSet flags;
    const ShotFit fit = fit_shot(*observe(frame, flags), {}, flags);
    Readout all;
    const Crossings crossings = propagate(fit, {}, all);
    for (const bool drag : {true, false}) {
      std::array<double, 2> acceleration{};
      for (std::size_t leg = 0; leg < 2; ++leg) {
        const double speed = *all.value[leg == 0 ? Quantity::v_td_mps : Quantity::v_lo_mps];
        acceleration[leg] =
            drag ? fit.air.drag_mps2(speed) : std::abs(fit.air.lift_mps2(speed, fit.spin[leg]->omega_radps));
      }
      const Quantities bound = change_bound(all, fit, crossings, acceleration);
      const Readout without = reduced(frame, {.effects = flight::Effects{true, !drag, drag}});
      for (std::size_t i = 0; i < kQuantityCount; ++i) {
        const auto q = static_cast<Quantity>(i);
        if (!bound[q]) continue;
        const double change = std::abs(*without.value[q] - *all.value[q]);
        char text[160];
        std::snprintf(text, sizeof text, "%s %s %s: changes by %.4g, bound %.4g", bounce.label.c_str(),
                      drag ? "drag" : "magnus", kQuantityNames[i].data(), change, *bound[q]);
        // The bound is of first order; 2 % leave room for the second.
        CHECK_TRUE_TEXT(change <= 1.02 * *bound[q] + 1e-9, text);
        // And not far above: it would be no bound to decide by.
        if (q == Quantity::v_td_mps && drag) CHECK_TRUE_TEXT(change > 0.2 * *bound[q], text);
      }
    }
  }
}

TEST_GROUP(ChangeBounds) {
  Readout readout;
  ShotFit fit;
  const Crossings crossings{0.010, 0.015};  // the farthest images are 10 and 20 ms away
  const std::array<double, 2> acceleration{2.0, 3.0};

  void setup() override {
    fit.joint.legs[0].first_s = 0.0, fit.joint.legs[0].last_s = 0.009;
    fit.joint.legs[1].first_s = 0.018, fit.joint.legs[1].last_s = 0.035;
    auto& v = readout.value;
    v[Quantity::vx_td_mps] = 4.0, v[Quantity::vy_td_mps] = -3.0, v[Quantity::v_td_mps] = 5.0;
    v[Quantity::vx_lo_mps] = 2.0, v[Quantity::vy_lo_mps] = 1.5, v[Quantity::v_lo_mps] = 2.5;
    v[Quantity::slip_lo_mps] = v[Quantity::e] = 0.5, v[Quantity::mu] = -0.4;
    v[Quantity::court_pace] = 30.0, v[Quantity::dwell_time_ms] = v[Quantity::dwell_distance_cm] = 5.0;
  }
};

TEST(ChangeBounds, AreThoseWorkedOutByHand) {
  // Velocities change by a T: 0.02 and 0.06 m/s; places by a T^2 / 2: 0.1 and 0.6 mm, passed in 0.1/3 and 0.6/1.5 ms.
  const double e = (0.06 + 0.5 * 0.02) / 3.0, mu = 0.08 * 1.4 / 4.5;
  const std::pair<Quantity, double> expected[] = {
      {Quantity::vx_td_mps, 0.02},
      {Quantity::vy_td_mps, 0.02},
      {Quantity::v_td_mps, 0.02},
      {Quantity::vx_lo_mps, 0.06},
      {Quantity::vy_lo_mps, 0.06},
      {Quantity::v_lo_mps, 0.06},
      {Quantity::theta_in_deg, degrees(0.02 / 5.0)},
      {Quantity::theta_out_deg, degrees(0.06 / 2.5)},
      {Quantity::slip_lo_mps, 0.06},
      {Quantity::e, e},
      {Quantity::mu, mu},
      {Quantity::court_pace, 100.0 * mu + 150.0 * e},
      {Quantity::dwell_time_ms, 0.1 / 3.0 + 0.4},
      {Quantity::dwell_distance_cm, 0.01 + 0.1 * 4.0 * 0.1 / 3.0 + 0.06 + 0.1 * 2.0 * 0.4}};
  const Quantities bound = change_bound(readout, fit, crossings, acceleration);
  for (const auto& [q, value] : expected) DOUBLES_EQUAL(value, *bound[q], 1e-12);
}

TEST(ChangeBounds, AreAbsentWhereTheNumberIs) {
  const auto bound_of = [&](Quantity q, const Crossings& at) {
    return change_bound(readout, fit, at, acceleration)[q];
  };
  for (const Quantity q :
       {Quantity::slip_lo_mps, Quantity::court_pace, Quantity::dwell_time_ms, Quantity::mu, Quantity::e}) {
    readout.value[q].reset();
    CHECK_FALSE(bound_of(q, crossings).has_value());
  }
  CHECK_FALSE(bound_of(Quantity::vx_td_mps, {std::nullopt, 0.015}).has_value());
  readout.value[Quantity::v_lo_mps].reset();
  CHECK_FALSE(bound_of(Quantity::vx_lo_mps, crossings).has_value());
}

TEST(ChangeBounds, OfATwentiethOfAnSdKeepTheEffect) {
  fit.air = flight::aerodynamics({}, flight::kAirDensity_kgpm3, {});
  fit.spin[0].emplace().omega_radps = 100.0;
  fit.spin[1].emplace().omega_radps = -300.0;
  const auto bounds = [&](auto acceleration_of) {
    return change_bound(readout, fit, crossings, {acceleration_of(5.0, 100.0), acceleration_of(2.5, -300.0)});
  };
  const Quantities drag = bounds([&](double v, double) { return fit.air.drag_mps2(v); });
  const Quantities lift =
      bounds([&](double v, double omega) { return std::abs(fit.air.lift_mps2(v, omega)); });
  const auto kept = [&] { return significant_effects(readout, fit, crossings, {}); };
  // The sd of all numbers but one leave room for both effects, its own for neither, or is unknown.
  const auto wide = [&](Quantity q) { return 20.2 * std::max(drag[q].value_or(0.0), lift[q].value_or(0.0)); };
  for (std::size_t i = 0; i < kQuantityCount; ++i)
    readout.sd[static_cast<Quantity>(i)] = wide(static_cast<Quantity>(i));
  CHECK_TRUE((kept() == flight::kGravityOnly));
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (!drag[q]) continue;
    readout.sd[q] = 19.8 * *drag[q];
    CHECK_TRUE(kept().drag);
    readout.sd[q] = 19.8 * *lift[q];
    CHECK_TRUE(kept().magnus);
    readout.sd[q].reset();
    CHECK_TRUE((kept() == flight::Effects{}));
    readout.sd[q] = wide(q);
  }
  readout.sd = {};
  CHECK_TRUE((significant_effects(readout, fit, crossings, flight::kGravityOnly) == flight::kGravityOnly));
}

TEST(FlightEffects, AreAllFittedToAFastShot) {
  const Readout r = reduced(photograph(Bounce{}, Setup{}));
  CHECK_EQUAL((flight::Effects{true, true, true}), r.flight_effects);
}

TEST(FlightEffects, WhatDoesNotMatterIsLeftOutAndSaid) {
  // A ball without spin has no lift.
  Bounce bounce;
  bounce.omega_td = bounce.omega_lo = 0.0;
  Setup setup = exact();
  Frame frame = photograph(bounce, setup);
  for (BallImage& image : frame.images) image.equator_rad = 0.3;
  CHECK_EQUAL((flight::Effects{true, true, false}), reduced(frame).flight_effects);
  // A slow ball, coarsely digitized: 1.5 m/s has 43 mm/s^2 of drag, half a millimetre a second in 14 ms.
  bounce.vx_td = 1.4, bounce.vy_td = -0.7, bounce.vx_lo = 1.0, bounce.vy_lo = 0.6, bounce.dwell_x_m = 0.006;
  CHECK_EQUAL(flight::kGravityOnly, reduced(photograph(bounce, setup)).flight_effects);
  // In a vacuum there is nothing to leave out, at any speed.
  setup.air = {.drag_coefficient = 0.0, .lift = false, .spin_decay_per_m = 0.0};
  frame = photograph(Bounce{}, setup);
  frame.air_density_kgpm3 = 0.0;
  const Readout r = reduced(frame);
  CHECK_EQUAL(flight::kGravityOnly, r.flight_effects);
  DOUBLES_EQUAL(Bounce{}.vx_td, *r.value[Quantity::vx_td_mps], 1e-8);
}

TEST(FlightEffects, AreThoseThatAreAskedFor) {
  const Frame frame = photograph(Bounce{}, exact());
  for (const flight::Effects effects :
       {flight::kNoEffects, flight::kGravityOnly, flight::Effects{true, true, false}})
    CHECK_EQUAL(effects, reduced(frame, {.effects = effects}).flight_effects);
  // Drag over half a leg: 5.5 m/s^2 for about 8 ms.
  const double with = *reduced(frame).value[Quantity::vx_td_mps];
  const double without = *reduced(frame, {.effects = flight::kGravityOnly}).value[Quantity::vx_td_mps];
  CHECK_TRUE(without - with > 0.02 && without - with < 0.08);
}

TEST(FlightEffects, TheOtherEstimatorsKnowNone) {
  for (const Estimator estimator : {Estimator::two_point, Estimator::legacy}) {
    const auto r = reduce(photograph(Bounce{}, Setup{}), estimator);
    CHECK_TRUE(r && r->flight_effects == flight::kNoEffects);
  }
}

TEST(FlightEffects, TheBallsMassAndTheAirsDensityAreTheFrames) {
  Frame frame = photograph(Bounce{}, exact());
  const auto excess = [](const Frame& f) {
    return *reduced(f, {.effects = flight::kGravityOnly}).value[Quantity::vx_td_mps] -
           *reduced(f, {.effects = flight::Effects{true, true, false}}).value[Quantity::vx_td_mps];
  };
  const double usual = excess(frame);
  frame.ball_mass_kg = 2 * 0.0576;
  DOUBLES_EQUAL(0.5, excess(frame) / usual, 0.01);
  frame.ball_mass_kg.reset();
  frame.air_density_kgpm3 = 2 * 1.204;
  DOUBLES_EQUAL(2.0, excess(frame) / usual, 0.02);
  frame.air_density_kgpm3.reset();
  frame.temperature_c = 20.0 - 29.315;  // a tenth colder, a ninth denser
  DOUBLES_EQUAL(10.0 / 9.0, excess(frame) / usual, 0.01);
}

TEST(FlightEffects, ThatCannotBeFittedThoughTheyMatterAreFlagged) {
  // A table tennis ball loses a seventh of its speed to the air in a metre.
  Bounce bounce;
  bounce.diameter_m = 0.04;
  Setup setup = exact();
  setup.air.mass_kg = 0.0027;
  Frame frame = photograph(bounce, setup);
  frame.ball_mass_kg = 0.0027;
  const auto flagged = [&](const ReduceOptions& options = {}) {
    return reduced(frame, options).flags.has(Flag::air_not_fitted);
  };
  CHECK_FALSE(flagged());
  setup.incoming = 20;
  frame = photograph(bounce, setup);
  frame.ball_mass_kg = 0.0027;
  CHECK_TRUE(flagged());
  CHECK_EQUAL(flight::kGravityOnly, reduced(frame).flight_effects);
  CHECK_TRUE(flagged({.effects = flight::Effects{}}));
  CHECK_EQUAL(flight::kGravityOnly, reduced(frame, {.effects = flight::Effects{}}).flight_effects);
  CHECK_FALSE(flagged({.effects = flight::kGravityOnly}));
}

TEST(FlightEffects, ALegOfManyMetresIsFittedWithoutAir) {
  // The series holds while the air takes a small part of the speed; 100 m at one flash a second is beyond it.
  Frame frame;
  frame.ball_diameter_m = 0.0651;
  frame.surface_px = {{0, 0}, {1000, 0}};
  frame.centre_sd_px = frame.diameter_sd_px = 1.0;
  for (int i = 0; i < 3; ++i) {
    BallImage image;
    image.time_s = i;
    image.leg = Leg::incoming;
    image.diameter_px = 65.1;
    image.centre_px = {30000.0 * i, 1000.0 * (100.0 - 10.0 * i - 4.903 * i * i)};
    frame.images.push_back(image);
  }
  const Readout r = reduced(frame);
  CHECK_FALSE(r.flight_effects.drag || r.flight_effects.magnus);
  CHECK_TRUE(r.flags.has(Flag::air_not_fitted));
}
