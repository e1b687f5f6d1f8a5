// What `strobe contact` reports about one set: computed by analyse(), printed as JSON or for people. Not
// thread-safe where it prints (stdout).
#pragma once

#include <optional>
#include <string>

#include "common/contact/differentiation/analysis.hpp"
#include "common/contact/differentiation/constrained_motion.hpp"
#include "common/contact/integration/integration.hpp"
#include "common/contact/mechanics_score.hpp"

namespace strobe::host {

struct ContactJob {
  std::string name;  ///< as given: a file or a project's set
  bool project_set = false;
  bool corrected = false;
  contact::ContactSet set;
  contact::Inputs inputs;
  double dwell_time_ms = 0.0;
  double dwell_distance_cm = 0.0;
  contact::SpinPulseInput pulse;  ///< its mu is the magnitude of inputs.mu
  contact::SpinPulseSd pulse_sd;  ///< zero for a file
  contact::EndVelocities ends;
  std::optional<double> omega_td_radps;  ///< absent: nothing is said about spin
  std::optional<double> omega_lo_radps;
  std::optional<double> total_rotation_rad;  ///< given; else the total that fits the pulse best
};

struct ContactReport {
  contact::Estimate estimate;  ///< friction throughout, as in the thesis
  contact::FractionFits fits;
  contact::Scale scale;
  contact::Peaks peaks;
  contact::Stiffness stiffness;
  contact::DropRatio drop;
  contact::ZeroCrossings zeros;
  std::optional<contact::Score> spin_score;  ///< of the pulse with its grip; absent without a spin
  contact::ContactState lift_off;
  const char* rotation_source = "unknown";           ///< "given", "fitted to the pulse" or "unknown"
  std::optional<contact::MechanicsScore> mechanics;  ///< fitted defaults; absent without a spin
  contact::ConstrainedMotion spline;
  contact::Score spline_score;
  std::optional<contact::ForcePeak> spline_force;
  contact::CrossValidation cross;
};

/// The message does not name the set.
Result<ContactReport> analyse(const ContactJob& job);

void print_contact_json(const ContactJob& job, const ContactReport& report);
void print_contact_table(const ContactJob& job, const ContactReport& report);

}  // namespace strobe::host
