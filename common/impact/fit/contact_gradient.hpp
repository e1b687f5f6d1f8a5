// The lift-off of the contact mechanics and its derivatives by the coefficients. Pure; thread-safe, real-time safe.
#pragma once

#include "common/impact/fit/rebound_model.hpp"

namespace strobe::impact {

/// Of vx and R·omega at lift-off, m/s for each unit of the parameter.
struct ContactGradient {
  std::array<double, kParameterCount> vx{};
  std::array<double, kParameterCount> spin{};
};

/// 0 for the parameters that ode does not have, and for the dwell time where the inputs have their own. Errors as for
/// rebound_of().
tl::expected<ContactGradient, InputError> contact_gradient(const ParameterValues& parameters,
                                                           double diameter_m, const ModelInputs& inputs);

}  // namespace strobe::impact
