// The report of `strobe contact` for one set. Writes to stdout; single-threaded.
#pragma once

#include <optional>
#include <string>

#include "common/contact/peaks.hpp"
#include "common/contact/standard_error.hpp"
#include "common/contact/stiffness.hpp"

namespace strobe::host {

struct ContactJob {
  std::string name;  ///< as given: a file or a project's set
  bool project_set = false;
  bool corrected = false;
  data::ContactSet set;
  contact::ContactInputs inputs;
  double dwell_time_ms = 0.0;
  double dwell_distance_cm = 0.0;
  contact::SpinPulseInput pulse;  ///< its mu is the magnitude of inputs.mu
  contact::SpinPulseSd pulse_sd;  ///< zero for a file
  contact::EndVelocities ends;
  std::optional<double> omega_td_radps;  ///< absent: no results about spin
  std::optional<double> omega_lo_radps;
  std::optional<double> total_rotation_rad;  ///< absent: the total that fits the pulse best
};

/// The contact ODE with the fitted coefficients.
struct MechanicsReport {
  contact::StandardErrors errors;
  impact::ContactSummary summary;
};

struct ContactReport {
  contact::StandardErrors thesis_errors;  ///< of the pulse with friction throughout, as in the thesis
  double damping_f = 0.0;
  contact::FractionFits fits;
  contact::ContactScale scale;
  contact::Peaks peaks;
  contact::Stiffness stiffness;
  contact::DropRatio drop;
  contact::ZeroCrossings zeros;
  std::optional<contact::StandardErrors> spin_errors;  ///< of the pulse with its grip; absent without a spin
  contact::SpinPulseState lift_off;
  const char* rotation_source = "unknown";   ///< "given", "fitted to the pulse" or "unknown"
  std::optional<MechanicsReport> mechanics;  ///< absent without a spin
  contact::ConstrainedMotion spline;
  contact::StandardErrors spline_errors;
  std::optional<contact::ForcePeak> spline_force;
  contact::CrossValidation cross;
};

void print_contact_json(const ContactJob& job, const ContactReport& report);
void print_contact_table(const ContactJob& job, const ContactReport& report);

}  // namespace strobe::host
