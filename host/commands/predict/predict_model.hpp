// The computation of `strobe predict`: one impact by the named model. Pure functions; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/impact/closed_form/sine_pulse.hpp"
#include "common/impact/ode/contact_trajectory.hpp"

namespace strobe::host {

/// Friction of the rigid models: the thesis's mean.
inline constexpr double kRigidMu = 0.55;

struct PredictInput {
  impact::Motion touchdown;
  std::string model = "grip";  ///< "rigid", "grip", "pulse", "ode"; "return_mapping" where it was chosen
  double e = impact::kFittedToThesis.e;
  std::optional<double> mu;     ///< absent: the model's own
  std::optional<double> alpha;  ///< absent: the model's own
  double e_x = impact::kFittedToThesis.e_x;
  double offset_mm = impact::kFittedToThesis.offset_m * 1e3;
  double diameter_m = ball::kThesisDiameter_m;
  double mass_kg = ball::kThesisMass_kg;
  double dwell_time_ms = impact::ContactCoefficients{}.dwell_s * 1e3;
  std::string form = "exact";
  impact::ContactCoefficients contact;
  impact::ContactOptions integration;
};

/// alpha and mu of a model where they are not given: the thesis's thin shell for rigid and pulse, fitted
/// values for grip and ode.
double default_alpha(std::string_view model);
double default_mu(std::string_view model);

ball::Ball ball_of(const PredictInput& in);
double mu_of(const PredictInput& in);
impact::ContactCoefficients contact_of(const PredictInput& in);

struct Prediction {
  impact::Rebound rebound;
  std::optional<impact::PulseRebound> pulse = std::nullopt;
  std::optional<impact::ContactTrajectory> contact = std::nullopt;
};

/// Errors: those of the model.
tl::expected<Prediction, impact::InputError> predict(const PredictInput& in);

/// The lift-off alone, at its own cost.
tl::expected<impact::Motion, impact::InputError> lift_off_only(const PredictInput& in);

}  // namespace strobe::host
