#include "common/impact/fit/comparison.hpp"

#include <cmath>

namespace strobe::impact {

namespace {

std::optional<double> z_if_known(double residual, double sd) {
  if (sd > 0.0) return residual / sd;
  return std::nullopt;
}

Comparison compare_one(const Observation& o, ReboundModel model, const ParameterValues& parameters,
                       double diameter_m) {
  const double radius = 0.5 * diameter_m;
  const InputCovariance inputs = input_covariance(model, parameters, diameter_m, o);
  Comparison out;
  out.predicted = *rebound_of(model, parameters, diameter_m, inputs_of(o));
  out.vx_residual_mps = o.lift_off.vx_mps - out.predicted.lift_off.vx_mps;
  out.omega_residual_radps = o.lift_off.omega_radps - out.predicted.lift_off.omega_radps;
  out.z_vx = z_if_known(out.vx_residual_mps, o.lift_off_sd.vx_mps);
  out.z_omega = z_if_known(out.omega_residual_radps, o.lift_off_sd.omega_radps);
  out.z_vx_with_inputs =
      z_if_known(out.vx_residual_mps, std::hypot(o.lift_off_sd.vx_mps, std::sqrt(inputs.vx)));
  out.z_omega_with_inputs = z_if_known(
      out.omega_residual_radps, std::hypot(o.lift_off_sd.omega_radps, std::sqrt(inputs.spin) / radius));
  return out;
}

/// Root mean square of the z-scores present, and how many are within one sd.
struct ZScores {
  int count = 0;
  int within = 0;
  double squares = 0.0;

  void add(const std::optional<double>& z) {
    if (!z) return;
    ++count;
    within += std::abs(*z) <= 1.0 ? 1 : 0;
    squares += *z * *z;
  }
  double rms() const { return count > 0 ? std::sqrt(squares / count) : 0.0; }
};

}  // namespace

std::vector<Comparison> compare(std::span<const Observation> observations, ReboundModel model,
                                const ParameterValues& parameters, double diameter_m) {
  std::vector<Comparison> out;
  out.reserve(observations.size());
  for (const Observation& o : observations) out.push_back(compare_one(o, model, parameters, diameter_m));
  return out;
}

ResidualStatistics residual_statistics(std::span<const Comparison> comparisons) {
  ResidualStatistics out;
  if (comparisons.empty()) return out;
  ZScores vx, omega;
  for (const Comparison& c : comparisons) {
    out.rms_vx_mps += c.vx_residual_mps * c.vx_residual_mps;
    out.rms_omega_radps += c.omega_residual_radps * c.omega_residual_radps;
    vx.add(c.z_vx);
    omega.add(c.z_omega);
  }
  const auto n = static_cast<double>(comparisons.size());
  out.count = static_cast<int>(comparisons.size());
  out.rms_vx_mps = std::sqrt(out.rms_vx_mps / n);
  out.rms_omega_radps = std::sqrt(out.rms_omega_radps / n);
  out.within_sd_vx = vx.within;
  out.within_sd_omega = omega.within;
  out.rms_z_vx = vx.rms();
  out.rms_z_omega = omega.rms();
  return out;
}

}  // namespace strobe::impact
