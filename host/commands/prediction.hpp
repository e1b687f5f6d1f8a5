// What strobe predict is asked, and the bounce in three dimensions. Allocates; thread-safe but for what
// prints.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/impact/ode/contact_ode.hpp"

namespace strobe::host::prediction {

struct PredictOptions {
  impact::Motion touchdown;
  double vz_mps = 0.0, omega_x_radps = 0.0, omega_y_radps = 0.0;  ///< out of the plane
  std::string model = "grip";                                     ///< "rigid", "grip", "pulse", "ode"
  double e = impact::kFittedToThesis.e;
  std::optional<double> mu;     ///< absent: the model's own
  std::optional<double> alpha;  ///< absent: the model's own
  double e_x = impact::kFittedToThesis.e_x;
  double offset_mm = impact::kFittedToThesis.offset_m * 1e3;
  double diameter_m = ball::kThesisDiameter_m;
  double mass_kg = ball::kThesisMass_kg;
  double dwell_time_ms = impact::ContactCoefficients{}.dwell_s * 1e3;
  impact::ContactCoefficients contact;
  impact::ContactOptions integration;
  std::string ball;                  ///< a kind's name or file; empty: a tennis ball
  std::vector<std::string> remarks;  ///< what of this impact is beyond what was measured of its kind
  int samples = 0;                   ///< of the contact's trajectory; 0: none
  bool json = false;
};

/// Of a model where it is not given: the thesis's thin shell for rigid and pulse, fitted values for grip and
/// ode.
double default_alpha(std::string_view model);
double default_mu(std::string_view model);

double mu_of(const PredictOptions& o);
ball::Ball ball_of(const PredictOptions& o);
impact::ContactCoefficients contact_of(const PredictOptions& o);
impact::Coefficients grip_of(const PredictOptions& o);

/// Whether it leaves the plane, or spins out of it.
inline bool is_spatial(const PredictOptions& o) {
  return o.vz_mps != 0.0 || o.omega_x_radps != 0.0 || o.omega_y_radps != 0.0;
}

nlohmann::ordered_json inputs_of(const PredictOptions& o);
nlohmann::ordered_json milliseconds_json(const std::optional<double>& time_s);
nlohmann::ordered_json energy_json(const impact::ContactEnergy& e);

/// The line's begin, without its end.
void print_model(const PredictOptions& o);

/// Prints the bounce in three dimensions, by rigid, grip or ode; returns the exit status.
int predict_spatial(const PredictOptions& o);

}  // namespace strobe::host::prediction
