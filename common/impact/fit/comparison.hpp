// Measured rebounds compared with a rebound model's predictions. Pure; thread-safe; compare() allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/impact/fit/rebound_model.hpp"

namespace strobe::impact {

/// One observation and its prediction. Residual: measured less predicted.
struct Comparison {
  Rebound predicted;
  double vx_residual_mps = 0.0;
  double omega_residual_radps = 0.0;
  std::optional<double> z_vx;  ///< residual over the lift-off's stated sd; absent if that is 0
  std::optional<double> z_omega;
  /// Over the sd of lift-off and of the prediction from touchdown and e (not from the parameters).
  std::optional<double> z_vx_with_inputs;
  std::optional<double> z_omega_with_inputs;
};

/// Over several comparisons; absent z-scores are left out.
struct ResidualStatistics {
  double rms_vx_mps = 0.0;
  double rms_omega_radps = 0.0;
  int count = 0;
  int within_sd_vx = 0;  ///< |z| <= 1
  int within_sd_omega = 0;
  double rms_z_vx = 0.0;
  double rms_z_omega = 0.0;
};

ResidualStatistics residual_statistics(std::span<const Comparison> comparisons);

/// Compares observations with a model of given parameters. Precondition: inputs that fit() accepts.
std::vector<Comparison> compare(std::span<const Observation> observations, ReboundModel model,
                                const ParameterValues& parameters, double diameter_m);

}  // namespace strobe::impact
