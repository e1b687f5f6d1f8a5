// Predictions and balances of published bounces, as text for people and JSON for scripts. Pure; thread-safe;
// allocates.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "host/bounces/prediction.hpp"
#include "host/figures/figure.hpp"

namespace strobe::bounces {

struct Row {
  Case bounce;
  std::array<Prediction, kModels.size()> predictions;
  std::optional<Balance> level;        ///< as if the surface were level
  std::optional<Balance> with_weight;  ///< the same where the incline is not published
};

/// All rows of a set. Fails as predict().
Result<std::vector<Row>> rows_of(const published::Bounces& all, const published::Set& set);

/// Of one model over rows; nothing where a row's own friction gives vx.
struct Agreement {
  int vx_count = 0, omega_count = 0;
  double vx_rms_mps = 0.0, omega_rms_radps = 0.0;
  double vx_z_rms = 0.0, omega_z_rms = 0.0;  ///< of residuals over their sds: 1 where those explain them
  int covered = 0;                           ///< within 95 % of the prediction, kCoverageSds
};
inline constexpr double kCoverageSds = 1.96;
Agreement agreement_of(const std::vector<Row>& rows, Model model);

/// The set's publication; measured and predicted vx and omega at lift-off, each with its residual's z; the
/// models' agreement; the balance of angular momentum.
std::string text(const published::Set& set, const std::vector<Row>& rows);

/// A line for each model: how many measured numbers it predicts, which share of them lies within 95 % of the
/// prediction, rms residuals, rms of z; over the rows that it is valid for or, where it is for none, over
/// all, with the reason against it.
std::string summary_head();
std::string summary(const published::Set& set, const std::vector<Row>& rows);

/// One object without line breaks: set, row, ball, surface, incline_deg; mu, mu_from, mu_elsewhere; measured
/// (vx_lo_mps, omega_lo_radps and their sds); predictions (by model: vx_lo_mps, vy_lo_mps, omega_lo_radps,
/// mu, vx_is_given, residuals, sds, not_valid: the reason against it, or empty); balance and balance_level
/// (alpha, offset_mm, sds, slip_lo_mps, ex). What is not published is null.
std::string json(const published::Set& set, const Row& row);

// Predicted against measured spin of published bounces. Pure; thread-safe; allocates.

/// A panel for tennis balls, one for solid balls, where there are any; a series for each model, besides the
/// line on which predicted is measured. Topspin counts positive.
figures::Figure spin_figure(const std::vector<Row>& rows);

}  // namespace strobe::bounces
