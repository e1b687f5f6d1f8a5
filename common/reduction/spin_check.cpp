#include "common/reduction/spin_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "common/ball/ball.hpp"
#include "common/reduction/lift_misfit.hpp"

namespace strobe::reduction {

namespace {

/// Half a shell's: no ball of rubber and felt has less (thesis, 0.508).
constexpr double kMinAlpha = 0.5;
/// The weight during the contact, and the air that the two-point estimator leaves out.
constexpr double kLeftOut_mps = 0.1;

struct Hypothesis {
  double omega_radps = 0.0;
  bool in_window = false;  ///< no flash of the train tells that it is too fast
};

/// At the surface: what the readings may mean besides the spin as fitted comes first.
std::vector<Hypothesis> hypotheses(const Readout& readout, const ShotFit& fit, std::size_t leg) {
  const auto& value = readout.value[leg == 0 ? Quantity::omega_td_radps : Quantity::omega_lo_radps];
  if (!value || !fit.spin[leg]) return {};
  const SpinFit& spin = *fit.spin[leg];
  std::vector<Hypothesis> all{{*value, true}};
  for (const double other : spin.alternatives_radps)
    all.push_back({*value + (other - spin.omega_radps), std::abs(other) <= spin.window_radps});
  return all;
}

}  // namespace

std::optional<Friction> Friction::of(const Readout& readout, const ShotFit& fit) {
  const Quantities& value = readout.value;
  const auto& before = value[Quantity::vx_td_mps];
  const auto& after = value[Quantity::vx_lo_mps];
  const auto& down = value[Quantity::vy_td_mps];
  const auto& up = value[Quantity::vy_lo_mps];
  if (!before || !after || !down || !up) return std::nullopt;
  const ball::Ball& ball = fit.observations.ball;
  Friction f;
  f.radius_m_ = ball.radius_m();
  constexpr double kNoBallsAlpha = 1e-3;  // a frame may state any, and quotients overflow
  f.least_alpha_ = std::clamp(ball.alpha, kNoBallsAlpha, kMinAlpha);
  f.greatest_alpha_ = std::max(ball::kThinShellAlpha, ball.alpha);
  f.vx_td_mps_ = *before;
  f.vx_lo_mps_ = *after;
  f.vy_td_mps_ = *down;
  f.vy_lo_mps_ = *up;
  f.impulse_mps_ = *up - *down;
  f.change_sd_mps_ = std::hypot(readout.sd[Quantity::vx_td_mps].value_or(0.0),
                                readout.sd[Quantity::vx_lo_mps].value_or(0.0));
  const auto spin_sd = [&](std::size_t leg) {
    return fit.spin[leg] ? std::sqrt(fit.spin[leg]->variance) : 0.0;
  };
  f.rim_sd_mps_ = f.radius_m_ * std::hypot(spin_sd(0), spin_sd(1));
  return f;
}

double Friction::gain_mps(double omega_td_radps, double omega_lo_radps) const {
  double least = std::numeric_limits<double>::infinity();
  for (const double alpha : {least_alpha_, greatest_alpha_}) {
    const double rim = std::sqrt(alpha) * radius_m_;
    const double before = std::hypot(vx_td_mps_, vy_td_mps_, rim * omega_td_radps);
    least = std::min(least, std::hypot(vx_lo_mps_, vy_lo_mps_, rim * omega_lo_radps) - before);
  }
  return least;
}

double Friction::contradiction_mps(double omega_td_radps, double omega_lo_radps) const {
  // As speeds of the rim: no quotient of a ball's size overflows.
  const double change = vx_lo_mps_ - vx_td_mps_;
  const double turn = radius_m_ * (omega_lo_radps - omega_td_radps);
  const double offset = kLargestOffset * impulse_mps_;
  const double tolerance =
      kLeftOut_mps + kLimit_sd * std::hypot(change_sd_mps_, greatest_alpha_ * rim_sd_mps_);
  const double least = std::min(least_alpha_ * turn, greatest_alpha_ * turn);
  const double greatest = std::max(least_alpha_ * turn, greatest_alpha_ * turn);
  const double turned =
      std::max({0.0, least - change - offset - tolerance, change - greatest - offset - tolerance});
  const double slip = vx_td_mps_ + radius_m_ * omega_td_radps;
  const double slip_after = vx_lo_mps_ + radius_m_ * omega_lo_radps;
  const double by_offset = offset / least_alpha_;
  const double slip_tolerance = kLeftOut_mps + kLimit_sd * std::hypot(change_sd_mps_, rim_sd_mps_);
  if (gain_mps(omega_td_radps, omega_lo_radps) > slip_tolerance)
    return std::numeric_limits<double>::infinity();
  const double gained = std::max(0.0, std::abs(slip_after) - std::abs(slip) - by_offset - slip_tolerance);
  if (std::abs(slip) < slip_tolerance) return turned + gained;
  // Where the ball grips, so much of the offset's turn goes into its travel; where it slid throughout, none.
  const bool slid = slip * slip_after > 0.0 && std::abs(slip_after) > by_offset + slip_tolerance;
  const double driven = tolerance + (slid ? 0.0 : offset / (1.0 + least_alpha_));
  return turned + gained + std::max(0.0, std::copysign(change, change * slip) - driven);
}

bool Friction::slides_too_easily(double omega_td_radps, double omega_lo_radps) const {
  const double slip = vx_td_mps_ + radius_m_ * omega_td_radps;
  const double slip_after = vx_lo_mps_ + radius_m_ * omega_lo_radps;
  const double tolerance = kLeftOut_mps + kLimit_sd * std::hypot(change_sd_mps_, rim_sd_mps_);
  const double by_offset = kLargestOffset * impulse_mps_ / least_alpha_;
  const bool slid = slip * slip_after > 0.0 && std::abs(slip_after) > by_offset + tolerance;
  return slid && std::abs(vx_lo_mps_ - vx_td_mps_) + tolerance < kMinFriction * impulse_mps_;
}

bool Friction::likely(double omega_td_radps, double omega_lo_radps) const {
  return allows(omega_td_radps, omega_lo_radps) && !slides_too_easily(omega_td_radps, omega_lo_radps);
}

std::array<double, 6> Friction::turns_radps() const {
  std::array<double, 6> turns{};
  std::size_t i = 0;
  for (const double alpha : {least_alpha_, greatest_alpha_}) {
    for (const double offset : {-kLargestOffset, 0.0, kLargestOffset})
      turns[i++] = (vx_lo_mps_ - vx_td_mps_ + offset * impulse_mps_) / alpha / radius_m_;
  }
  return turns;
}

bool Friction::likely_before(double omega_td_radps) const {
  return std::ranges::any_of(turns_radps(),
                             [&](double turn) { return likely(omega_td_radps, omega_td_radps + turn); });
}

bool Friction::likely_after(double omega_lo_radps, double fastest_radps) const {
  return std::ranges::any_of(turns_radps(), [&](double turn) {
    return std::abs(omega_lo_radps - turn) <= fastest_radps && likely(omega_lo_radps - turn, omega_lo_radps);
  });
}

namespace {

using Hypotheses = std::array<std::vector<Hypothesis>, 2>;

bool spins_in_doubt(const Hypotheses& spins, const std::optional<Friction>& friction, const ShotFit& fit) {
  const auto& [before, after] = spins;
  const double fastest = fit.observations.fastest_spin_radps();
  const auto others = [](const std::vector<Hypothesis>& all, const auto& likely) {
    return !all.empty() && std::any_of(all.begin() + 1, all.end(),
                                       [&](const Hypothesis& h) { return likely(h.omega_radps); });
  };
  if (!friction) {
    const auto possible = [&](double omega) { return std::abs(omega) <= fastest; };
    return others(before, possible) || others(after, possible);
  }
  if (before.empty())
    return others(after, [&](double omega) { return friction->likely_after(omega, fastest); });
  if (after.empty()) return others(before, [&](double omega) { return friction->likely_before(omega); });
  const auto possible = [&](const Hypothesis& td, const Hypothesis& lo) {
    return td.in_window && lo.in_window ? friction->allows(td.omega_radps, lo.omega_radps)
                                        : friction->likely(td.omega_radps, lo.omega_radps);
  };
  const auto contradiction = [&](const Hypothesis& td, const Hypothesis& lo) {
    return friction->contradiction_mps(td.omega_radps, lo.omega_radps);
  };
  const double as_fitted = contradiction(before.front(), after.front());
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (std::size_t k = i == 0 ? 1 : 0; k < after.size(); ++k) {
      if (possible(before[i], after[k]) || contradiction(before[i], after[k]) < as_fitted) return true;
    }
  }
  // As much as half of a half turn more between two flashes would explain, though that is faster than any
  // known ball's.
  const double interval_s = std::max(fit.spin[0]->interval_s, fit.spin[1]->interval_s);
  return as_fitted * interval_s > 0.5 * std::numbers::pi * kMinAlpha * fit.observations.ball.radius_m();
}

/// Noise, and the decay to the surface.
constexpr double kJustFaster = 1.05;

/// Excess of those that no faster than usual spins explain: 0.
struct SpinCandidate {
  std::optional<double> omega_radps;  ///< absent: the leg shows no spin
  double excess = 0.0;
  bool faster = false;
  bool probable = true;
};

std::vector<SpinCandidate> spin_candidates(const std::vector<Hypothesis>& known, const ShotFit& fit,
                                           std::size_t leg) {
  if (known.empty()) return std::vector<SpinCandidate>(1);
  std::vector<SpinCandidate> all;
  for (const Hypothesis& h : known) all.push_back({h.omega_radps});
  const double to_surface = known.front().omega_radps - fit.spin[leg]->omega_radps;
  for (const OtherSpin& other : faster_spins(fit, leg))
    all.push_back({other.omega_radps + to_surface, other.excess, true, other.probable});
  return all;
}

bool friction_allows(const std::optional<Friction>& friction, const SpinCandidate& td,
                     const SpinCandidate& lo, double fastest_radps) {
  if (!friction) return true;
  if (!lo.omega_radps) return friction->likely_before(*td.omega_radps);
  if (!td.omega_radps) return friction->likely_after(*lo.omega_radps, fastest_radps);
  return friction->likely(*td.omega_radps, *lo.omega_radps);
}

/// What the pair is compared with, and by.
struct Comparison {
  const ShotFit& fit;
  const std::optional<Friction>& friction;
  std::array<std::optional<double>, 2> fitted_radps;
  std::optional<LiftMisfit> lift = std::nullopt;  ///< absent: not asked yet
};

/// Raises `excess` by the paths' where it comes to that.
SpinEvidence what_excludes(const SpinCandidate& td, const SpinCandidate& lo, Comparison& with,
                           double& excess) {
  const double possible_radps = kTearingRim_mps / with.fit.observations.ball.radius_m();
  if (!friction_allows(with.friction, td, lo, possible_radps)) return SpinEvidence::friction;
  if (!with.lift) with.lift.emplace(with.fit);
  excess +=
      with.lift->chi_squared({td.omega_radps, lo.omega_radps}) - with.lift->chi_squared(with.fitted_radps);
  return excess >= kComparableSpins ? SpinEvidence::lift : SpinEvidence::assumed_limit;
}

/// The spins fitted contradict friction, or are themselves beyond what was assumed.
bool fitted_improbable(const Comparison& c) {
  const auto& [td, lo] = c.fitted_radps;
  if (std::abs(td.value_or(0.0)) > kJustFaster * c.fit.observations.fastest_spin_radps()) return true;
  return c.friction && td && lo && !c.friction->allows(*td, *lo);
}

void check_faster(const Hypotheses& spins, const std::optional<Friction>& friction, const ShotFit& fit,
                  SpinCheck& check) {
  if (fit.observations.stated_fastest_radps) return;
  const std::array all{spin_candidates(spins[0], fit, 0), spin_candidates(spins[1], fit, 1)};
  Comparison comparison{fit, friction, {all[0].front().omega_radps, all[1].front().omega_radps}};
  bool probable = false;
  for (const SpinCandidate& td : all[0]) {
    for (const SpinCandidate& lo : all[1]) {
      double excess = td.excess + lo.excess;
      if (!(td.faster || lo.faster) || excess >= kComparableSpins) continue;
      const SpinEvidence excluded = what_excludes(td, lo, comparison, excess);
      check.told_by.set(excluded);
      if (excluded != SpinEvidence::assumed_limit || !td.probable || !lo.probable) continue;
      probable = true;
      check.far_better |= excess < -kFarBetter;
    }
  }
  check.faster = check.far_better || (probable && fitted_improbable(comparison));
}

}  // namespace

SpinCheck check_spins(const Readout& readout, const ShotFit& fit) {
  const Hypotheses spins{hypotheses(readout, fit, 0), hypotheses(readout, fit, 1)};
  SpinCheck check;
  if (spins[0].empty() && spins[1].empty()) return check;
  const auto friction = Friction::of(readout, fit);
  check.in_doubt = spins_in_doubt(spins, friction, fit);
  check_faster(spins, friction, fit, check);
  if (spins[0].size() > 1 || spins[1].size() > 1) check.told_by.set(SpinEvidence::friction);
  if (check.told_by.empty()) check.told_by.set(SpinEvidence::train);
  if (check.in_doubt || check.faster) check.told_by = {};
  return check;
}

}  // namespace strobe::reduction
