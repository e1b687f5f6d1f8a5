#include "common/impact/ode/contact_course.hpp"

#include <algorithm>
#include <iterator>

#include "common/impact/ode/collocation_summary.hpp"
#include "common/impact/ode/contact_trajectory.hpp"

namespace strobe::impact {

namespace {

ContactMotion motion_of(const detail::CollocationConstants& c, const detail::SegmentPoint& at) {
  const detail::System& s = c.system;
  const double metre = s.speed_mps / s.frequency_radps, tau = at.normal.tau;
  const detail::TangentialState& t = at.tangential;
  return {metre * s.path(tau, c.path_change(t, tau)),
          0.0 - metre * at.normal.depth,
          metre * (s.w0 * tau + t.angle) / s.radius_m,
          {s.speed_mps * (s.vx0 + c.vx_change(t, tau)), -s.speed_mps * at.normal.rate,
           s.speed_mps * c.spin(t) / s.radius_m}};
}

}  // namespace

tl::expected<ContactCourse, InputError> ContactCourse::make(const ball::Ball& ball, const Motion& touchdown,
                                                            const ContactCoefficients& coefficients,
                                                            const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  ContactCourse out;
  ContactOptions by_steps = options;
  if (detail::collocates(options)) {
    out.tolerance_ = options.tolerance;
    out.constants_ = detail::CollocationConstants::make(*system);
    if (out.constants_) {
      if (const auto contact = detail::collocate(*out.constants_, options.tolerance, out.starts_)) {
        out.lift_off_ = detail::lift_off_of(*out.constants_, *contact);
        return out;
      }
    }
    out.constants_.reset();
    out.starts_.clear();
    by_steps = {.method = ContactMethod::dormand_prince, .tolerance = 1e-12};  // as lift_off() does
  }
  auto steps = ContactTrajectory::make(ball, touchdown, coefficients, by_steps);
  if (!steps) return tl::unexpected(steps.error());
  out.lift_off_ = detail::lift_off_of(steps->summary());
  out.by_steps_ = std::make_shared<const ContactTrajectory>(*std::move(steps));
  return out;
}

ContactMotion ContactCourse::at(double time_s) const {
  if (by_steps_) {
    const ContactState s = by_steps_->at(time_s);
    return {s.x_m, s.y_m, s.rotation_rad, {s.vx_mps, s.vy_mps, s.omega_radps}};
  }
  const detail::System& s = constants_->system;
  const double tau = std::clamp(time_s * s.frequency_radps, 0.0, constants_->normal.release_tau());
  const auto after = std::upper_bound(starts_.begin(), starts_.end(), tau,
                                      [](double t, const detail::SegmentStart& g) { return t < g.from.tau; });
  const detail::SegmentStart& start = after == starts_.begin() ? starts_.front() : *std::prev(after);
  return motion_of(*constants_, detail::point_at(*constants_, tolerance_, start, tau));
}

}  // namespace strobe::impact
