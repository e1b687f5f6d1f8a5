#include "host/series/drift.hpp"

#include <fmt/format.h>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/statistics/distributions.hpp"

namespace strobe::host {
namespace {

using reduction::Estimate;

/// What one unit of a culprit's number does to a witness; numbers of different columns are free on their own.
struct Effect {
  Witness witness;
  int column;
  double by;  ///< per unit; times the number before where `relative`
  bool relative;
};

/// A scale that is larger by 1 % than the calibration's shows larger balls and a larger gravity; a larger
/// ball larger balls; without a calibration the balls are gravity's scale. A clock that is fast by 1 % makes
/// gravity smaller by 2 %.
std::vector<Effect> effects_of(Culprit culprit, bool calibrated) {
  using enum Witness;
  switch (culprit) {
    case Culprit::scale:
      return {{diameters_px_per_m, 0, 1.0, true}, {gravity_mps2, 0, calibrated ? 1.0 : 0.0, true}};
    case Culprit::ball:
      return {{diameters_px_per_m, 0, 1.0, true}, {gravity_mps2, 0, calibrated ? 0.0 : -1.0, true}};
    case Culprit::clock:
      return {{gravity_mps2, 0, -2.0, true}, {clock_ppm, 0, -1e6, false}};
    case Culprit::tilt:
      return {{surface_deg, 0, 1.0, false}};
    case Culprit::lamp_a:
      return {{lamp_a_us, 0, 1.0, false}};
    case Culprit::lamp_b:
      return {{lamp_b_us, 0, 1.0, false}};
    case Culprit::air:
      return {{gravity_mps2, 0, 1.0, true}};
    case Culprit::lens:
      return {
          {path_residuals, 0, 1.0, false}, {gravity_mps2, 1, 1.0, true}, {diameters_px_per_m, 2, 1.0, true}};
  }
  return {};
}

constexpr double kAsGood = 9.0;
constexpr double kNoExplanation = 1e-4;

struct Fit {
  double chi_squared = 0.0;
  double unknowns = 0.0;
  double score() const { return chi_squared + kAsGood * (unknowns - 1.0); }
};

/// Weighted least squares of the culprit's sizes.
Fit fit_of(Culprit culprit, std::span<const WitnessShift> shifts, bool calibrated) {
  constexpr int kMaxColumns = 3;
  const auto rows = static_cast<Eigen::Index>(shifts.size());
  Eigen::MatrixXd by = Eigen::MatrixXd::Zero(rows, kMaxColumns);
  Eigen::VectorXd seen(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const WitnessShift& shift = shifts[static_cast<std::size_t>(i)];
    seen(i) = shift.change.value / shift.change.sd;
    for (const Effect& e : effects_of(culprit, calibrated))
      if (e.witness == shift.witness)
        by(i, e.column) = e.by * (e.relative ? shift.before.value : 1.0) / shift.change.sd;
  }
  // Columns of very different units.
  for (Eigen::Index k = 0; k < kMaxColumns; ++k)
    if (const double norm = by.col(k).norm(); norm > 0.0) by.col(k) /= norm;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(by);
  const double chi_squared = (seen - by * factor.solve(seen)).squaredNorm();
  return {chi_squared, static_cast<double>(factor.rank())};
}

double limit_of_charts() {
  static const double limit = decision_interval(kShotsPerFalseAlarm * static_cast<double>(kWitnessCount));
  return limit;
}

}  // namespace

std::vector<Culprit> culprits(std::span<const WitnessShift> shifts, bool calibrated) {
  std::vector<std::pair<double, Culprit>> explaining;
  for (std::size_t i = 0; i < kCulpritCount; ++i) {
    const auto culprit = static_cast<Culprit>(i);
    const Fit fit = fit_of(culprit, shifts, calibrated);
    if (fit.unknowns == 0.0) continue;
    const double freedom = static_cast<double>(shifts.size()) - fit.unknowns;
    if (freedom > 0.0 && fit.chi_squared > 0.0 &&
        statistics::chi_squared_tail(fit.chi_squared, freedom) < kNoExplanation)
      continue;
    explaining.emplace_back(fit.score(), culprit);
  }
  std::ranges::sort(explaining);
  std::vector<Culprit> found;
  for (const auto& [score, culprit] : explaining)
    if (score < explaining.front().first + kAsGood) found.push_back(culprit);
  return found;
}

WitnessCharts::WitnessCharts() : limit_(limit_of_charts()) {}

std::vector<Witness> WitnessCharts::add(const std::string& shot, const ShotWitnesses& witnesses) {
  std::vector<Witness> alarms;
  shots_.push_back(shot);
  calibrated_ = calibrated_ || witnesses.calibrated;
  for (std::size_t i = 0; i < kWitnessCount; ++i) {
    if (!witnesses.of[i]) continue;
    auto& chart = charts_[i];
    if (!chart) chart.emplace(limit_, witnesses.of[i]->reference);
    const bool before = chart->alarm().has_value();
    chart->add(shots_.size() - 1, witnesses.of[i]->measured);
    if (chart->alarm() && !before) alarms.push_back(static_cast<Witness>(i));
  }
  return alarms;
}

const ControlChart* WitnessCharts::chart(Witness w) const {
  const auto& chart = charts_[static_cast<std::size_t>(w)];
  return chart ? &*chart : nullptr;
}

std::vector<WitnessShift> WitnessCharts::shifts_since(std::size_t shot) const {
  std::vector<WitnessShift> shifts;
  for (std::size_t i = 0; i < kWitnessCount; ++i) {
    if (!charts_[i]) continue;
    const auto& points = charts_[i]->points();
    const auto first = std::ranges::lower_bound(points, shot, {}, &ChartPoint::shot);
    const auto before = charts_[i]->in_control(static_cast<std::size_t>(first - points.begin()));
    double sum = 0.0, weight = 0.0;
    for (auto p = first; p != points.end(); ++p) {
      const double w = 1.0 / (p->measured.sd * p->measured.sd);
      sum += w * p->measured.value;
      weight += w;
    }
    if (!before || !(weight > 0.0)) continue;
    const double sd = std::hypot(before->scatter_factor / std::sqrt(weight), before->mean.sd);
    shifts.push_back({static_cast<Witness>(i), before->mean, {sum / weight - before->mean.value, sd}});
  }
  return shifts;
}

std::optional<DriftVerdict> WitnessCharts::verdict() const {
  DriftVerdict verdict;
  std::size_t since = shots_.size();
  std::vector<std::pair<std::size_t, DriftAlarm>> alarms;
  for (std::size_t i = 0; i < kWitnessCount; ++i) {
    if (!charts_[i] || !charts_[i]->alarm()) continue;
    const auto& points = charts_[i]->points();
    const std::size_t told = points[*charts_[i]->alarm()].shot, began = points[charts_[i]->since()].shot;
    alarms.emplace_back(told, DriftAlarm{static_cast<Witness>(i), shots_[told], shots_[began]});
    since = std::min(since, began);
  }
  if (alarms.empty()) return std::nullopt;
  std::ranges::stable_sort(alarms, {}, [](const auto& a) { return a.first; });
  for (auto& [told, alarm] : alarms) verdict.alarms.push_back(std::move(alarm));
  verdict.shifts = shifts_since(since);
  verdict.culprits = culprits(verdict.shifts, calibrated_);
  return verdict;
}

WitnessCharts charts_of(std::span<const Shot> shots) {
  WitnessCharts charts;
  for (const Shot& shot : shots)
    if (!shot.rejected) charts.add(shot.full_name(), witnesses(shot));
  return charts;
}

}  // namespace strobe::host
