#include "common/impact/ode/contact_ode.hpp"

#include <cmath>

#include "common/impact/ode/contact_collocation.hpp"
#include "common/impact/ode/contact_integrator.hpp"

namespace strobe::impact {

namespace detail {

namespace {

/// The point of low…high where the function, of opposite signs there, is 0, to `enough` of it: false position
/// with the Illinois weights, and a bisection every fourth time.
template <typename Function>
double zero_of(const Function& f, double low, double at_low, double high, double at_high, double enough) {
  int side = 0;
  for (int i = 1; i < 100 && high - low > enough * high && at_high != 0.0; ++i) {
    const double fall = at_high - at_low;  // of denormal numbers it may be 0
    double middle = i % 4 == 0 || fall == 0.0 ? 0.5 * (low + high) : (low * at_high - high * at_low) / fall;
    if (!(middle > low && middle < high)) middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) break;
    const double value = f(middle);
    const bool before = (value > 0.0) == (at_low > 0.0) && value != 0.0;
    if (before) {
      low = middle;
      at_low = value;
      if (side == 1) at_high *= 0.5;
    } else {
      high = middle;
      at_high = value;
      if (side == -1) at_low *= 0.5;
    }
    side = before ? 1 : -1;
  }
  return high;
}

/// The changes of speeds, path and angle up to release.
State release_motion(const CollocationConstants& c, const CollocatedContact& contact) {
  State z{};
  z[kDepthRate] = contact.rate;
  z[kVxChange] = c.vx_change(contact.release, contact.tau);
  z[kSpinChange] = c.spin_change(contact.release);
  z[kPathChange] = c.path_change(contact.release, contact.tau);
  z[kAngleChange] = contact.release.angle;
  return z;
}

/// What ContactSummary has besides the lift-off, from a contact's segments.
class SummaryOfSegments {
 public:
  SummaryOfSegments(const CollocationConstants& c, const CollocatedContact& contact, const Segments& segments)
      : c_(c), s_(c.system), contact_(contact), segments_(segments) {}

  ContactSummary make() {
    if (s_.slip0 == 0.0) slip_zero_tau_ = 0.0;
    for (std::size_t i = 0; i < segments_.count; ++i) {
      const Segment& segment = segments_.all[i];
      look_through(segment);
      if (i + 1 == segments_.count || segments_.all[i + 1].mode == segment.mode) continue;
      add(segment.mode == ContactMode::grips ? ContactEventKind::slip : ContactEventKind::grip,
          segments_.all[i + 1].from.tau);
    }
    extremes();
    add(ContactEventKind::release, contact_.tau);
    fill();
    return out_;
  }

 private:
  /// What may change its sign along a segment, and the friction.
  struct Signs {
    double slip, friction, friction_rate;
  };

  Signs signs_of(const Segment& segment, const NodeSample& at) const {
    const TangentialRates rates = rates_at(c_, segment.mode, at);
    const double friction = segment.mode == ContactMode::grips ? s_.kt * at.stretch + s_.ct * at.slip
                                                               : direction(segment.mode) * s_.mu * at.force;
    return {at.slip, friction, s_.kt * rates.stretch + s_.ct * rates.slip};
  }
  Signs signs_on(const Segment& segment, double x) const {
    const SegmentPoint p = point_on(c_, segment, x);
    const double spin = c_.spin(p.tangential);
    return signs_of(segment, {0.0, c_.normal.force(p.normal), c_.normal.force_rate(p.normal),
                              c_.couple_rate(p.normal, spin), p.tangential.slip, p.tangential.stretch, spin});
  }

  /// Between the start, the nodes and the end.
  void look_through(const Segment& segment) {
    const RuleView rule = rule_of(segment);
    double before = segment.x;
    Signs last = signs_on(segment, before);
    friction_max_ = std::max(friction_max_, std::abs(last.friction));
    for (std::size_t i = 0; i <= rule.node.size(); ++i) {
      const bool node = i < rule.node.size();
      const double x = segment.x + segment.size * (node ? rule.node[i] : 1.0);
      const Signs now = node ? signs_of(segment, segment.samples[i]) : signs_on(segment, x);
      look_between(segment, before, last, x, now);
      friction_max_ = std::max(friction_max_, std::abs(now.friction));
      before = x;
      last = now;
    }
  }

  void look_between(const Segment& segment, double before, const Signs& last, double x, const Signs& now) {
    const auto turns = [](double a, double b) { return (a > 0.0 && b <= 0.0) || (a < 0.0 && b >= 0.0); };
    if (!slip_zero_tau_ && turns(last.slip, now.slip)) {
      slip_zero_tau_ = tau_of(zero_of([&](double at) { return signs_on(segment, at).slip; }, before,
                                      last.slip, x, now.slip, 4e-16));
    }
    if (segment.mode != ContactMode::grips) return;
    if (turns(last.friction, now.friction)) {
      ++out_.friction_reversals;
      add(ContactEventKind::friction_reversal,
          tau_of(zero_of([&](double at) { return signs_on(segment, at).friction; }, before, last.friction, x,
                         now.friction, 4e-16)));
    }
    if (!turns(last.friction_rate, now.friction_rate)) return;
    // Friction is flat there: to the root of its own digits.
    const double at = zero_of([&](double p) { return signs_on(segment, p).friction_rate; }, before,
                              last.friction_rate, x, now.friction_rate, 1e-5);
    friction_max_ = std::max(friction_max_, std::abs(signs_on(segment, at).friction));
  }

  void extremes() {
    deepest_ = c_.normal.deepest_tau();
    if (deepest_ < contact_.tau) add(ContactEventKind::deepest, deepest_);
    largest_ = c_.normal.largest_force_tau();
    if (largest_ == 0.0) return;
    add(ContactEventKind::largest_force, largest_);
    for (std::size_t i = segments_.count; i-- > 0;) {
      if (segments_.all[i].from.tau > largest_) continue;
      if (segments_.all[i].mode != ContactMode::grips)
        friction_max_ = std::max(friction_max_, s_.mu * c_.normal.force(c_.normal.at(largest_)));
      return;
    }
  }

  double tau_of(double x) const { return std::min(c_.normal.tau(x), contact_.tau); }

  void add(ContactEventKind kind, double tau) { add_event(out_, {tau / s_.frequency_radps, kind}); }

  void fill() {
    const double second = 1.0 / s_.frequency_radps, metre = s_.speed_mps * second;
    const double newton = s_.mass_kg * s_.speed_mps * s_.frequency_radps;
    const State z = release_state(c_, contact_);
    const double normal_impulse = 1.0 - contact_.rate;
    static_cast<ContactLiftOff&>(out_) = lift_off_of(c_, contact_);
    if (slip_zero_tau_) out_.slip_zero_s = *slip_zero_tau_ * second;
    out_.max_depth_m = c_.normal.at(deepest_).depth * metre;
    out_.max_depth_time_s = deepest_ * second;
    out_.max_force_n = c_.normal.force(c_.normal.at(largest_)) * newton;
    out_.max_force_time_s = largest_ * second;
    out_.max_friction_n = friction_max_ * newton;
    out_.slip_lo_mps = s_.speed_mps * contact_.release.slip;
    out_.impulse_ratio = (0.0 - z[kVxChange]) / normal_impulse;
    out_.mean_offset_m = s_.radius_m * contact_.release.couple / normal_impulse;
    out_.energy = energy_at_release(s_, z, contact_.tau);
    add_losses(z);
    out_.steps = contact_.segments;
    out_.evaluations = contact_.evaluations;
  }

  /// By the node sums of the segments.
  void add_losses(const State& z) {
    double sliding = 0.0, damping = 0.0, offset = 0.0;
    for (std::size_t k = 0; k < segments_.count; ++k) {
      const Segment& segment = segments_.all[k];
      for (std::size_t i = 0; i < segment.nodes; ++i) {
        const NodeSample& at = segment.samples[i];
        const TangentialRates rates = rates_at(c_, segment.mode, at);
        if (segment.mode != ContactMode::grips)
          sliding += at.weight * direction(segment.mode) * s_.mu * at.force * (at.slip - rates.stretch);
        damping += at.weight * s_.ct * rates.stretch * rates.stretch;
        offset -= at.weight * rates.couple * at.spin;
      }
    }
    const double unit = s_.mass_kg * s_.speed_mps * s_.speed_mps;
    const double vy = contact_.rate, depth = z[kDepth];
    ContactEnergy& e = out_.energy;
    // The normal motion by itself keeps its balance.
    const double normal_lost = 0.5 * (1.0 - vy) * (1.0 + vy);
    e.normal_damping_j =
        s_.zeta == 0.0 ? 0.0 : unit * (normal_lost - 0.5 * depth * depth + s_.gravity * depth);
    e.sliding_j = unit * sliding;
    e.tangential_damping_j = unit * damping;
    e.offset_j = unit * offset;
  }

  /// Without the losses.
  static State release_state(const CollocationConstants& c, const CollocatedContact& contact) {
    State z = release_motion(c, contact);
    z[kDepth] = c.normal.at(contact.tau).depth;
    z[kStretch] = contact.release.stretch;
    return z;
  }

  const CollocationConstants& c_;
  const System& s_;
  const CollocatedContact& contact_;
  const Segments& segments_;
  ContactSummary out_;
  std::optional<double> slip_zero_tau_;
  double deepest_ = 0.0, largest_ = 0.0, friction_max_ = 0.0;
};

}  // namespace

ContactSummary summary_of(const CollocationConstants& c, const CollocatedContact& contact,
                          const Segments& segments) {
  return SummaryOfSegments(c, contact, segments).make();
}

ContactLiftOff lift_off_of(const CollocationConstants& c, const CollocatedContact& contact) {
  ContactLiftOff out = lift_off_of(c.system, release_motion(c, contact), contact.tau);
  out.regime = contact.regime();
  if (const auto tau = contact.skid_to_grip_tau())
    out.skid_to_grip_s = *tau * (1.0 / c.system.frequency_radps);
  return out;
}

}  // namespace detail

tl::expected<ContactSummary, InputError> simulate(const ball::Ball& ball, const Motion& touchdown,
                                                  const ContactCoefficients& coefficients,
                                                  const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  if (detail::collocates(options)) {
    if (const auto constants = detail::CollocationConstants::make(*system)) {
      detail::Segments segments;
      const auto contact = detail::collocate(*constants, options.tolerance, true, &segments);
      if (contact) return detail::summary_of(*constants, *contact, segments);
    }
  }
  return detail::integrate(*system, options, nullptr);
}

tl::expected<ContactLiftOff, InputError> lift_off(const ball::Ball& ball, const Motion& touchdown,
                                                  const ContactCoefficients& coefficients,
                                                  const ContactOptions& options) {
  const auto system = detail::make_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  if (detail::collocates(options)) {
    if (const auto constants = detail::CollocationConstants::make(*system))
      if (const auto contact = detail::collocate(*constants, options.tolerance, false, nullptr))
        return detail::lift_off_of(*constants, *contact);
  }
  return detail::integrate(*system, options, nullptr);
}

}  // namespace strobe::impact
