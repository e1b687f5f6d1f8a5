#include "common/impact/ode/contact_trajectory.hpp"

#include <algorithm>
#include <iterator>

namespace strobe::impact {

tl::expected<ContactTrajectory, InputError> ContactTrajectory::make(const ball::Ball& ball,
                                                                    const Motion& touchdown,
                                                                    const ContactCoefficients& coefficients,
                                                                    const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  if (detail::collocates(options))
    if (auto solved = by_collocation(*system, options.tolerance)) return std::move(*solved);
  ContactTrajectory out;
  out.system_ = *system;
  const auto summary = detail::integrate(out.system_, options, &out.steps_);
  if (!summary) return tl::unexpected(summary.error());
  out.summary_ = *summary;
  return out;
}

std::optional<ContactTrajectory> ContactTrajectory::by_collocation(const detail::System& system,
                                                                   double tolerance) {
  ContactTrajectory out;
  out.system_ = system;
  out.constants_ = detail::CollocationConstants::make(system);
  if (!out.constants_) return std::nullopt;
  detail::Segments segments;
  const auto contact = detail::collocate(*out.constants_, tolerance, true, &segments);
  if (!contact) return std::nullopt;
  out.summary_ = detail::summary_of(*out.constants_, *contact, segments);
  out.segments_.assign(segments.all.begin(),
                       segments.all.begin() + static_cast<std::ptrdiff_t>(segments.count));
  return out;
}

/// Its losses are what the mechanical energy lacks, as one sum.
detail::State ContactTrajectory::state_by_collocation(double tau, ContactMode& mode) const {
  const detail::System& s = system_;
  const auto after = std::upper_bound(segments_.begin(), segments_.end(), tau,
                                      [](double t, const detail::Segment& g) { return t < g.from.tau; });
  const detail::Segment& segment = after == segments_.begin() ? segments_.front() : *std::prev(after);
  mode = segment.mode;
  const double x = std::clamp(constants_->normal.x_of(tau), segment.x, segment.x + segment.size);
  const detail::SegmentPoint p = detail::whole_point_on(*constants_, segment, x);
  detail::State z{};
  const double dx = constants_->vx_change(p.tangential, tau);
  const double dw = constants_->spin_change(p.tangential);
  const double y = p.normal.depth, vy = p.normal.rate, u = p.tangential.stretch;
  z[detail::kDepth] = y;
  z[detail::kDepthRate] = vy;
  z[detail::kVxChange] = dx;
  z[detail::kSpinChange] = dw;
  z[detail::kStretch] = u;
  z[detail::kPathChange] = constants_->path_change(p.tangential, tau);
  z[detail::kAngleChange] = p.tangential.angle;
  z[detail::kDampingLoss] =
      (0.5 * (1.0 - vy) * (1.0 + vy) - dx * (s.vx0 + 0.5 * dx) - s.alpha * dw * (s.w0 + 0.5 * dw)) -
      0.5 * (y * y + s.kt * u * u) + s.gravity * y + s.along * s.path(tau, z[detail::kPathChange]);
  return z;
}

ContactState ContactTrajectory::at(double time_s) const {
  if (constants_) {
    const double tau = std::clamp(time_s * system_.frequency_radps, 0.0, constants_->normal.release_tau());
    ContactMode mode = ContactMode::grips;
    const detail::State z = state_by_collocation(tau, mode);
    return state_of(z, tau, mode);
  }
  const detail::ContactStep& last = steps_.back();
  const double tau = std::clamp(time_s * system_.frequency_radps, 0.0, last.tau + last.size);
  const auto after = std::upper_bound(steps_.begin(), steps_.end(), tau,
                                      [](double t, const detail::ContactStep& s) { return t < s.tau; });
  const detail::ContactStep& step = after == steps_.begin() ? steps_.front() : *std::prev(after);
  const double part = std::min(tau - step.tau, step.size);
  const detail::State z =
      part > 0.0 ? detail::take_step(system_, step.mode, step.start, step.derivative, part) : step.start;
  return state_of(z, tau, step.mode);
}

ContactState ContactTrajectory::state_of(const detail::State& z, double tau, ContactMode mode) const {
  const detail::System& s = system_;
  const double second = 1.0 / s.frequency_radps;
  const double metre = s.speed_mps * second;
  const double newton = s.mass_kg * s.speed_mps * s.frequency_radps;
  const double joule = s.mass_kg * s.speed_mps * s.speed_mps;
  const double vx = s.vx0 + z[detail::kVxChange];
  const double w = s.spin(z);
  const double vy = z[detail::kDepthRate];
  const double depth = z[detail::kDepth];
  const double stretch = z[detail::kStretch];
  ContactState out;
  out.time_s = tau * second;
  out.x_m = metre * s.path(tau, z[detail::kPathChange]);
  out.y_m = 0.0 - metre * depth;
  out.rotation_rad = metre * (s.w0 * tau + z[detail::kAngleChange]) / s.radius_m;
  out.vx_mps = s.speed_mps * vx;
  out.vy_mps = -s.speed_mps * vy;
  out.omega_radps = s.speed_mps * w / s.radius_m;
  out.fx_n = 0.0 - newton * s.friction(z, mode);
  out.fy_n = newton * std::max(s.normal_force(z), 0.0);
  out.mode = mode;
  out.slip_mps = s.speed_mps * s.slip(z);
  out.offset_m = s.radius_m * s.offset(z);
  out.mechanical_energy_j =
      joule * (0.5 * (vx * vx + vy * vy + s.alpha * w * w + depth * depth + s.kt * stretch * stretch) -
               s.gravity * depth - s.along * s.path(tau, z[detail::kPathChange]));
  out.dissipated_j = joule * (z[detail::kDampingLoss] + z[detail::kSlidingLoss] + z[detail::kTangentialLoss] +
                              z[detail::kOffsetLoss]);
  return out;
}

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
  out.lift_off_ = steps->summary();
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
