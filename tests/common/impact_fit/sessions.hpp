// Sessions of shots with a known truth, of every kind that a laboratory sees, to hold the intervals of a fit against.
// The rebounds are those of impulse_balance.hpp, or of the contact ODE, which no rebound model matches exactly.
#pragma once

#include <array>
#include <random>
#include <string_view>
#include <vector>

#include "common/impact/fit/model_fit.hpp"

namespace strobe::testing {

enum class SessionKind {
  sliding,    ///< all slide
  gripping,   ///< all grip
  mixed,      ///< needing half to twice the friction there is
  repeated,   ///< three to eight conditions, each several times
  scattered,  ///< eight conditions or more, whose mu and e_x differ from one to the next
  varying,    ///< e_x differs from shot to shot
  thesis,     ///< the thesis's conditions, one to three shots of each
  misstated,  ///< the sds are stated at half of what they are
  unstated,   ///< without sds
  contact     ///< by the contact ODE: the truth is what the fit of very many such shots without noise gives
};
inline constexpr std::array<std::string_view, 10> kSessionKinds{
    "sliding", "gripping", "mixed",     "repeated", "scattered",
    "varying", "thesis",   "misstated", "unstated", "contact"};

struct Session {
  std::vector<impact::Observation> shots;
  impact::ParameterValues truth{};
  impact::FitOptions options;  ///< those of `strobe fit FILE`
};

/// 12 to 60 shots with touchdown as the thesis's machine throws and noise of a quarter to once that of digitizing by hand,
/// differing from shot to shot by half as much again.
Session draw_session(SessionKind kind, std::mt19937_64& source);

/// What the intervals of many fits held.
struct Coverage {
  int intervals = 0;  ///< of fitted parameters
  int held = 0;
  int below = 0;  ///< truth below the lower end
  int above = 0;
  int limits = 0;  ///< one-sided ones
  int limits_held = 0;
  double squares = 0.0;  ///< of the deviations in sds

  void add(const impact::FittedParameter& fitted, double truth);
  double rms_z() const;
};

using CoverageByParameter = std::array<Coverage, impact::kParameterCount>;

}  // namespace strobe::testing
