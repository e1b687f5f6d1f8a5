#include "host/bounces/prediction.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include "common/flight/gravity.hpp"
#include "common/impact/closed_form/elastic_rebound.hpp"
#include "common/impact/closed_form/turf.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "common/units/angles.hpp"

namespace strobe::bounces {

namespace {

using published::Bounce;
using published::Build;
using published::Measured;

constexpr double kUnpublishedRestitution = 0.75;
constexpr double kMinTangentialDamping = 0.01;  ///< least c_t of the mechanics, but none

constexpr double kPoissonOfRubber = 0.5;

/// Normal speeds of the impacts that support the constants of grip and mechanics (a tennis ball's file,
/// [contact]).
constexpr double kMinNormal_mps = 2.0, kMaxNormal_mps = 16.0;

ball::Ball ball_of(const Case& c, double alpha) {
  return {.diameter_m = c.ball.diameter_m, .mass_kg = c.ball.mass_kg, .alpha = alpha};
}

impact::Motion touchdown_of(const Bounce& b) {
  return {b.vx_td_mps.value, b.vy_td_mps.value, b.omega_td_radps.value};
}

/// At most 1, also where an error moves it beyond.
double restitution_of(const Bounce& b) {
  return std::min(1.0, b.restitution().value_or(kUnpublishedRestitution));
}

/// Of a ball that slides, whose weight takes part.
double impulse_ratio_under_weight(const Bounce& b, double dwell_s) {
  const Weight weight = weight_of(b);
  return (b.vx_td_mps.value - b.vx_lo_mps->value + weight.along_mps2 * dwell_s) /
         (b.vy_lo_mps->value - b.vy_td_mps.value + weight.into_mps2 * dwell_s);
}

double stiffness_ratio_of(const Case& c) {
  return impact::mindlin_stiffness_ratio(c.ball.poisson_ratio.value_or(kPoissonOfRubber));
}

double mu_of(const Case& c, Model model) {
  if (model != Model::known) return c.mu();
  if (c.friction.elsewhere) return c.friction.elsewhere->value;
  if (c.friction.row.empty()) return c.friction.mu;
  return impulse_ratio_under_weight(c.friction_row ? *c.friction_row : c.bounce, c.dwell_s);
}

impact::ContactCoefficients coefficients_of(const Case& c, Model model) {
  impact::ContactCoefficients out{.e = restitution_of(c.bounce), .dwell_s = c.dwell_s, .mu = mu_of(c, model)};
  if (model != Model::known) return out;
  const Weight weight = weight_of(c.bounce);
  out.gravity_mps2 = weight.into_mps2;
  out.gravity_along_mps2 = weight.along_mps2;
  if (c.ball.build == Build::solid) {
    out.stiffness_ratio = stiffness_ratio_of(c);
    // c_t/k_t = c/k with c = 2·zeta·sqrt(k·m): c_t/sqrt(k_t·m) = 2·zeta·sqrt(k_t/k); none below what the
    // mechanics take.
    const auto zeta = impact::damping_ratio_from_restitution(out.e);
    out.damping_ratio = 2.0 * zeta.value_or(0.0) * std::sqrt(out.stiffness_ratio);
    if (out.damping_ratio < kMinTangentialDamping) out.damping_ratio = 0.0;
    out.offset_share = 0.0;
  }
  return out;
}

tl::expected<impact::Motion, impact::InputError> lift_off_of(const Case& c, Model model) {
  const impact::Motion touchdown = touchdown_of(c.bounce);
  const auto motion = [](const auto& rebound) { return rebound.lift_off; };
  const bool shell = c.ball.build == Build::shell;
  const double alpha = c.ball.alpha.value;
  switch (model) {
    case Model::rigid:
      return impact::rigid(ball_of(c, shell ? ball::kThinShellAlpha : alpha), touchdown,
                           restitution_of(c.bounce), c.mu())
          .map(motion);
    case Model::grip: {
      impact::Coefficients fitted = impact::kFittedToThesis;
      fitted.e = restitution_of(c.bounce);
      fitted.mu = c.mu();
      if (!shell) fitted.offset_m *= c.ball.diameter_m / ball::kThesisDiameter_m;
      return impact::grip(ball_of(c, alpha), touchdown, fitted).map(motion);
    }
    case Model::mechanics:
      return impact::simulate(ball_of(c, shell ? impact::kContactAlpha : alpha), touchdown,
                              coefficients_of(c, model))
          .map(motion);
    case Model::elastic:
      return impact::elastic_rebound(
                 ball_of(c, alpha), touchdown,
                 {.e = restitution_of(c.bounce), .mu = c.mu(), .stiffness_ratio = stiffness_ratio_of(c)})
          .map(motion);
    case Model::known:
      break;
  }
  if (c.friction.ground == published::Ground::turf)
    return impact::rigid_on_turf(ball_of(c, alpha), touchdown, restitution_of(c.bounce), mu_of(c, model))
        .map(motion);
  return impact::simulate(ball_of(c, alpha), touchdown, coefficients_of(c, model)).map(motion);
}

/// Predicted less measured, without sds.
struct Difference {
  double vx_mps = 0.0;
  double omega_radps = 0.0;
};

tl::expected<Difference, impact::InputError> difference_of(const Case& c, Model model) {
  return lift_off_of(c, model).map([&c](const impact::Motion& lift_off) {
    const auto less = [](double predicted, const std::optional<Measured>& measured) {
      return measured ? predicted - measured->value : 0.0;
    };
    return Difference{less(lift_off.vx_mps, c.bounce.vx_lo_mps),
                      less(lift_off.omega_radps, c.bounce.omega_lo_radps)};
  });
}

/// The measured numbers that enter, each with its sd.
std::vector<Measured*> numbers_of(Bounce& b) {
  std::vector<Measured*> all{&b.vx_td_mps, &b.vy_td_mps, &b.omega_td_radps};
  for (std::optional<Measured>* number : {&b.vx_lo_mps, &b.vy_lo_mps, &b.omega_lo_radps})
    if (*number) all.push_back(&**number);
  return all;
}

std::vector<Measured*> numbers_of(Case& c, Model model, Measured& dwell) {
  std::vector<Measured*> all = numbers_of(c.bounce);
  if (c.friction_row)
    for (Measured* number : numbers_of(*c.friction_row)) all.push_back(number);
  if (model == Model::rigid || model == Model::mechanics) return all;
  all.push_back(&c.ball.alpha);
  if (model != Model::known) return all;
  if (c.friction.elsewhere) all.push_back(&*c.friction.elsewhere);
  all.push_back(&dwell);
  return all;
}

/// Each number moved by one sd either way; half the difference is its share (a secant: the border between
/// sliding and gripping is a kink).
tl::expected<Residual, impact::InputError> residual_of(Case c, Model model) {
  const auto middle = difference_of(c, model);
  if (!middle) return tl::unexpected(middle.error());
  Measured dwell{c.dwell_s, kDwellSd_s};
  double vx_variance = 0.0, omega_variance = 0.0;
  for (Measured* number : numbers_of(c, model, dwell)) {
    const double value = number->value;
    std::array<Difference, 2> ends{};
    for (const int i : {0, 1}) {
      number->value = value + (i == 0 ? -number->sd : number->sd);
      c.dwell_s = dwell.value;
      const auto moved = difference_of(c, model);
      if (!moved) return tl::unexpected(moved.error());
      ends[static_cast<std::size_t>(i)] = *moved;
    }
    number->value = value;
    c.dwell_s = dwell.value;
    vx_variance += std::pow((ends[1].vx_mps - ends[0].vx_mps) / 2.0, 2);
    omega_variance += std::pow((ends[1].omega_radps - ends[0].omega_radps) / 2.0, 2);
  }
  Residual out;
  if (c.bounce.vx_lo_mps) out.vx_mps = Measured{middle->vx_mps, std::sqrt(vx_variance)};
  if (c.bounce.omega_lo_radps) out.omega_radps = Measured{middle->omega_radps, std::sqrt(omega_variance)};
  return out;
}

}  // namespace

double Case::mu() const {
  if (tells_its_own_friction()) return bounce.impulse_ratio().value_or(0.0);
  return friction_row ? friction_row->impulse_ratio().value_or(0.0) : friction.mu;
}

std::vector<Case> cases_of(const published::Bounces& all, const published::Set& set) {
  std::vector<Case> out;
  for (const Bounce& bounce : set.bounces) {
    Case c{.ball = *all.ball(bounce.ball), .bounce = bounce, .friction = *set.friction(bounce.surface)};
    if (!c.friction.row.empty() && !c.tells_its_own_friction()) c.friction_row = *set.bounce(c.friction.row);
    out.push_back(std::move(c));
  }
  return out;
}

Result<Prediction> predict(const Case& bounce, Model model) {
  const auto refused = [&bounce](impact::InputError error) {
    return fail(bounce.bounce.name + ": " + std::string(impact::message(error)));
  };
  const auto lift_off = lift_off_of(bounce, model);
  if (!lift_off) return refused(lift_off.error());
  const auto residual = residual_of(bounce, model);
  if (!residual) return refused(residual.error());
  const bool given = bounce.tells_its_own_friction() && !(model == Model::known && bounce.friction.elsewhere);
  return Prediction{.lift_off = *lift_off,
                    .residual = *residual,
                    .mu = mu_of(bounce, model),
                    .vx_is_given = given,
                    .not_valid = not_valid(bounce, model)};
}

std::string_view not_valid(const Case& c, Model model) {
  using published::Ground;
  const Ground ground = c.friction.ground;
  const bool shell = c.ball.build == Build::shell;
  if (ground == Ground::turf) return model == Model::known ? "" : "ground yields";
  if (ground == Ground::strings) return "strings give way";
  if (model == Model::elastic) return shell ? "ball is hollow" : ground == Ground::pad ? "pad gives way" : "";
  if (model == Model::rigid || (model == Model::known && !shell)) return "";
  if (!shell) return "constants of a tennis ball";
  const double normal_mps = -c.bounce.vy_td_mps.value;
  const bool supported = normal_mps >= kMinNormal_mps && normal_mps <= kMaxNormal_mps;
  return supported ? "" : "normal speed outside 2-16 m/s";
}

Weight weight_of(const Bounce& bounce) {
  if (!bounce.incline_deg) return {};
  const double incline = radians(*bounce.incline_deg);
  return {flight::kStandardGravity_mps2 * std::sin(incline),
          flight::kStandardGravity_mps2 * std::cos(incline)};
}

namespace {

impact::Observation observation_of(const published::Bounce& b, double along_mps) {
  const double e = *b.restitution();
  return {.name = b.name,
          .spin = {},
          .series = {},
          .touchdown = {b.vx_td_mps.value, b.vy_td_mps.value, b.omega_td_radps.value},
          .touchdown_sd = {b.vx_td_mps.sd, b.vy_td_mps.sd, b.omega_td_radps.sd},
          .lift_off = {b.vx_lo_mps->value - along_mps, b.vy_lo_mps->value, b.omega_lo_radps->value},
          .lift_off_sd = {b.vx_lo_mps->sd, b.vy_lo_mps->sd, b.omega_lo_radps->sd},
          .e = e,
          .e_sd = e * std::hypot(b.vy_td_mps.sd / b.vy_td_mps.value, b.vy_lo_mps->sd / b.vy_lo_mps->value)};
}

}  // namespace

std::optional<Balance> balance_of(const Case& c, bool with_weight) {
  const published::Bounce& b = c.bounce;
  if (!b.vx_lo_mps || !b.vy_lo_mps || !b.omega_lo_radps) return std::nullopt;
  const double radius_m = c.ball.diameter_m / 2.0;
  const double along_mps2 = with_weight ? weight_of(b).along_mps2 : 0.0;
  const double change_mps = b.vx_lo_mps->value - b.vx_td_mps.value - along_mps2 * c.dwell_s;
  const double spin_mps = radius_m * (b.omega_lo_radps->value - b.omega_td_radps.value);
  if (spin_mps == 0.0) return std::nullopt;
  const auto friction = impact::rolling_friction(
      observation_of(b, along_mps2 * c.dwell_s),
      {.diameter_m = c.ball.diameter_m, .mass_kg = c.ball.mass_kg, .alpha = c.ball.alpha.value},
      c.ball.alpha.sd);
  if (!friction) return std::nullopt;
  const double alpha = change_mps / spin_mps;
  const double weight_sd_mps = along_mps2 * kDwellSd_s;
  const double change_sd = std::hypot(b.vx_lo_mps->sd, b.vx_td_mps.sd, weight_sd_mps);
  const double slip_lo_mps = b.vx_lo_mps->value + radius_m * b.omega_lo_radps->value;
  const double spin_sd = radius_m * std::hypot(b.omega_lo_radps->sd, b.omega_td_radps.sd);
  return Balance{.alpha = {alpha, std::hypot(change_sd, alpha * spin_sd) / std::abs(spin_mps)},
                 .offset_m = {friction->offset_m, friction->offset_sd_m},
                 .offset_sd_alpha_m = friction->offset_sd_alpha_m,
                 .slip_lo_mps = slip_lo_mps,
                 .e_x = -slip_lo_mps / (b.vx_td_mps.value + radius_m * b.omega_td_radps.value)};
}

MeanAlpha mean_of(std::span<const published::Measured> alphas) {
  assert(std::ranges::all_of(alphas, [](const published::Measured& a) { return a.sd > 0.0; }));
  double weights = 0.0, sum = 0.0;
  for (const published::Measured& a : alphas) {
    weights += 1.0 / (a.sd * a.sd);
    sum += a.value / (a.sd * a.sd);
  }
  MeanAlpha mean{.alpha = {sum / weights, 1.0 / std::sqrt(weights)},
                 .count = static_cast<int>(alphas.size())};
  for (const published::Measured& a : alphas)
    mean.chi_square += std::pow((a.value - mean.alpha.value) / a.sd, 2);
  return mean;
}

}  // namespace strobe::bounces
