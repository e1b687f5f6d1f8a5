#include "common/impact/fit/contact_gradient.hpp"

#include <algorithm>

#include "common/impact/ode/contact_sensitivity.hpp"

namespace strobe::impact {

namespace {

ContactInput input_of(Parameter p) {
  switch (p) {
    case Parameter::mu:
      return ContactInput::mu;
    case Parameter::offset_reference_mps:
      return ContactInput::offset_reference_mps;
    case Parameter::alpha:
      return ContactInput::alpha;
    case Parameter::stiffness_ratio:
      return ContactInput::stiffness_ratio;
    case Parameter::damping_ratio:
      return ContactInput::damping_ratio;
    case Parameter::offset_share:
      return ContactInput::offset_share;
    default:
      return ContactInput::dwell_s;
  }
}

}  // namespace

tl::expected<ContactGradient, InputError> contact_gradient(const ParameterValues& parameters,
                                                           double diameter_m, const ModelInputs& inputs) {
  const ContactInputs contact = contact_inputs(parameters, diameter_m, inputs);
  return lift_off_with_sensitivity(contact.ball, inputs.touchdown, contact.coefficients, contact.options)
      .map([&](const ContactSensitivity& s) {
        ContactGradient out;
        for (std::size_t i = 0; i < kParameterCount; ++i) {
          const auto p = static_cast<Parameter>(i);
          if (!has_parameter(ReboundModel::ode, p)) continue;
          const bool is_dwell = p == Parameter::dwell_s;
          if (is_dwell && inputs.dwell_s > 0.0) continue;
          const double factor = is_dwell ? contact.share_until_release : 1.0;
          out.vx[i] = factor * s.of(ContactOutput::vx_mps, input_of(p));
          out.spin[i] = factor * contact.ball.radius_m() * s.of(ContactOutput::omega_radps, input_of(p));
        }
        return out;
      });
}

}  // namespace strobe::impact
