#include "host/commands/predict/predict_model.hpp"

#include <utility>

#include "common/impact/ode/return_mapping.hpp"

namespace strobe::host {

double default_alpha(std::string_view model) {
  if (model == "grip") return ball::kMeasuredAlpha;
  return model == "ode" ? impact::kContactAlpha : ball::kThinShellAlpha;
}

double default_mu(std::string_view model) {
  if (model == "grip") return impact::kFittedToThesis.mu;
  return model == "ode" ? impact::ContactCoefficients{}.mu : kRigidMu;
}

ball::Ball ball_of(const PredictInput& in) {
  return {.diameter_m = in.diameter_m,
          .mass_kg = in.mass_kg,
          .alpha = in.alpha.value_or(default_alpha(in.model))};
}

double mu_of(const PredictInput& in) { return in.mu.value_or(default_mu(in.model)); }

impact::ContactCoefficients contact_of(const PredictInput& in) {
  impact::ContactCoefficients c = in.contact;
  c.e = in.e;
  c.mu = mu_of(in);
  c.dwell_s = in.dwell_time_ms / 1e3;
  return c;
}

tl::expected<Prediction, impact::InputError> predict(const PredictInput& in) {
  const ball::Ball ball = ball_of(in);
  const double mu = mu_of(in);
  if (in.model == "pulse") {
    const auto form = in.form == "simplified" ? impact::PulseForm::simplified : impact::PulseForm::exact;
    return impact::pulse_rebound(form, ball, in.touchdown, in.e, mu, in.dwell_time_ms / 1e3)
        .map([](const impact::PulseRebound& p) { return Prediction{.rebound = p.rebound, .pulse = p}; });
  }
  if (in.model == "ode") {
    return impact::ContactTrajectory::make(ball, in.touchdown, contact_of(in), in.integration)
        .map([](impact::ContactTrajectory&& contact) {
          const impact::ContactSummary& s = contact.summary();
          return Prediction{.rebound = {.lift_off = s.lift_off,
                                        .regime = s.regime,
                                        .slip_lo_mps = s.slip_lo_mps,
                                        .impulse_ratio = s.impulse_ratio,
                                        .offset_m = s.mean_offset_m},
                            .contact = std::move(contact)};
        });
  }
  if (in.model == "return_mapping")
    return impact::return_mapping(ball, in.touchdown, contact_of(in), in.integration.steps)
        .map([](const impact::Rebound& r) { return Prediction{.rebound = r}; });
  const auto rebound =
      in.model == "rigid"
          ? impact::rigid(ball, in.touchdown, in.e, mu)
          : impact::grip(ball, in.touchdown,
                         {.e = in.e, .mu = mu, .e_x = in.e_x, .offset_m = in.offset_mm / 1e3});
  return rebound.map([&](impact::Rebound r) {
    r.regime = impact::regime_of(ball, in.touchdown, r);
    return Prediction{.rebound = r};
  });
}

tl::expected<impact::Motion, impact::InputError> lift_off_only(const PredictInput& in) {
  if (in.model == "ode")
    return impact::lift_off(ball_of(in), in.touchdown, contact_of(in), in.integration)
        .map([](const impact::ContactLiftOff& end) { return end.lift_off; });
  return predict(in).map([](const Prediction& p) { return p.rebound.lift_off; });
}

}  // namespace strobe::host
