#include "common/impact/ode/contact_integrator.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

#include "common/impact/ode/event_location.hpp"
#include "common/impact/ode/normal_spring.hpp"

namespace strobe::impact::detail {

namespace {

constexpr int kMaxSteps = 1'000'000;
constexpr double kMaxTime = 400.0;        // about 130 dwell times: at rest but for rounding
constexpr double kChatteringStep = 1e-7;  // where rounding cannot tell grip from slip
constexpr double kMaxStep = 0.25;
constexpr double kMinScale = 1e-200;  // of an energy that is not spent; its inverse is finite
constexpr double kSafety = 0.1;       // fraction of the tolerance at release that one step may use

class ContactIntegrator {
 public:
  ContactIntegrator(const System& system, double tolerance, std::vector<ContactStep>* steps)
      : s_(system), tolerance_(tolerance), stored_(steps), mode_(initial_mode(system)) {
    z_[kDepthRate] = 1.0;
    started_gripping_ = mode_ == ContactMode::grips;
    size_ = std::min(1e-2, first_size());
    set_scales();
    if (stored_) stored_->clear();
    if (s_.slip0 == 0.0) slip_zero_ = 0.0;
    force_max_ = s_.normal_force(z_);
    friction_max_ = std::abs(s_.friction(z_, mode_));
  }

  tl::expected<ContactSummary, InputError> integrate_to_release() {
    derivative_ = derivative(s_, z_, mode_);
    for (int i = 0; i < kMaxSteps; ++i) {
      step();
      if (released_) return summary();
      if (tau_ > kMaxTime || is_held()) return tl::unexpected(InputError::no_release);
    }
    return tl::unexpected(InputError::too_many_steps);
  }

 private:
  /// N swings about the weight as a damped oscillator: where it turns above 0 it stays there, and overdamped
  /// it may come down to the weight without passing it.
  bool is_held() const {
    const double excess = s_.normal_force(z_) - s_.gravity, rate = s_.normal_force_rate(z_);
    if (excess < 0.0) return z_[kDepthRate] < 0.0 && rate >= 0.0;
    return s_.gravity > 0.0 && s_.zeta >= 1.0 &&
           rate + (s_.zeta + std::sqrt((s_.zeta - 1.0) * (s_.zeta + 1.0))) * excess >= 0.0;
  }

  /// The footprint's radius starts as a square root of time, which the embedded error estimate sees only in
  /// part: its error in the first step is kept below the tolerance by the step's size.
  double first_size() const {
    const double smooth = 0.05 * std::pow(tolerance_, 0.2);
    if (s_.delta == 0.0) return smooth;
    // That error grows as size^1.5 over the root of the time in which the footprint fills.
    return std::min(smooth, 0.2 * std::pow(tolerance_, 2.0 / 3.0) * std::cbrt(std::min(1.0, s_.radius)));
  }

  void set_scales() {
    // N falls to 0 at a rate of e: the slower, the less of an error the time of release bears.
    const double e = restitution_of_damping_ratio(s_.zeta);
    const double normal = std::min(1.0, 10.0 * e * s_.release_phase / (1.0 + 2.0 * s_.zeta));
    const double tangential = s_.tangential_scale();
    const double energy =
        tangential * (std::abs(s_.slip0) + tangential + (s_.delta > 0.0 ? std::abs(s_.w0) : 0.0));
    scale_.fill(tangential);
    scale_[kDepth] = scale_[kDepthRate] = scale_[kDampingLoss] = normal;
    scale_[kStretch] = tangential / std::max(1.0, s_.kt);
    scale_[kSlidingLoss] = scale_[kTangentialLoss] = scale_[kOffsetLoss] = std::max(energy, kMinScale);
    for (double& scale : scale_) scale = 1.0 / (scale * kSafety * tolerance_);
    // The offset turns round within w0 of spin 0.
    if (s_.delta > 0.0 && s_.ahead == 0.0)
      scale_[kSpinChange] = std::max(scale_[kSpinChange], 100.0 / s_.w_ref);
  }

  struct Event {
    double size;  ///< from the step's start
    EventFunction function;
  };

  /// The first event in the step that ends it.
  std::optional<Event> first_event(const DenseStep& dense) const {
    std::optional<Event> first;
    const auto consider = [&](EventFunction function) {
      const auto size = find_crossing(dense, function);
      // The release wins a tie: mu·N and N vanish together.
      if (size && (!first || *size < first->size * (1.0 - 1e-13))) first = {*size, function};
    };
    consider(EventFunction::release);
    if (mode_ == ContactMode::grips) {
      consider(EventFunction::hold_forward);
      consider(EventFunction::hold_backward);
    } else {
      consider(EventFunction::sliding);
    }
    if (s_.delta > 0.0) consider(full_ ? EventFunction::footprint_shrinks : EventFunction::footprint_full);
    return first;
  }

  static bool switches_mode(EventFunction function) {
    return function == EventFunction::hold_forward || function == EventFunction::hold_backward ||
           function == EventFunction::sliding;
  }

  /// One step, up to the next event if there is one.
  void step() {
    if (is_leaving()) return release();
    const double size = attempt();
    DenseStep dense{
        s_, {tau_, size, mode_, z_, derivative_}, end_, derivative(s_, end_, mode_), &evaluations_};
    ++evaluations_;
    dense.interpolate_quarters();
    if (size <= kChatteringStep && chattering_ > 2) {
      chattering_ = 0;
      return advance(dense, size, end_, std::nullopt);
    }
    const auto event = first_event(dense);
    if (!event) return advance(dense, size, end_, std::nullopt);
    if (event->size == 0.0 && switches_mode(event->function)) return switch_mode(event->function, true);
    return advance(dense, event->size, dense.at(event->size), event->function);
  }

  /// Takes a step into end_ and returns its size.
  double attempt() {
    if (chattering_ > 2) size_ = std::min(size_, kChatteringStep);
    for (;;) {
      State error;
      end_ = take_step_with_error(s_, mode_, z_, derivative_, size_, error);
      evaluations_ += 6;
      double worst = 0.0;
      for (std::size_t i = 0; i < kComponents; ++i) worst = std::max(worst, std::abs(error[i]) * scale_[i]);
      const double size = size_;
      const double factor = worst > 0.0 ? std::clamp(0.9 * std::pow(worst, -0.2), 0.2, 5.0) : 5.0;
      if (worst <= 1.0 || size <= 1e-14) {
        next_size_ = std::min(size * factor, kMaxStep);
        return size;
      }
      size_ = size * factor;
    }
  }

  /// N has come to its rounding of 0, where no step finds a change of sign any more.
  bool is_leaving() const {
    const EventValue force = event_value(s_, EventFunction::release, mode_, z_);
    return force.value <= force.noise && s_.normal_force_rate(z_) < 0.0;
  }

  void release() {
    released_ = true;
    add(ContactEventKind::release, tau_);
  }

  void advance(const DenseStep& dense, double size, const State& end, std::optional<EventFunction> event) {
    record_extrema(dense, size, end);
    if (stored_) {
      stored_->push_back(dense.step);
      stored_->back().size = size;
    }
    ++steps_;
    assert(size >= 0.0 && size <= dense.step.size);
    if (event != EventFunction::release && tau_ + size > tau_) chattering_ = 0;
    tau_ += size;
    z_ = end;
    update_force_max(z_, tau_, false);
    friction_max_ = std::max(friction_max_, std::abs(s_.friction(z_, mode_)));
    size_ = event ? std::max(size_ - size, 0.1 * size_) : next_size_;
    if (event == EventFunction::release) return release();
    if (event == EventFunction::footprint_full || event == EventFunction::footprint_shrinks)
      full_ = event == EventFunction::footprint_full;
    else if (event)
      return switch_mode(*event, false);
    derivative_ = size == dense.step.size ? dense.end_derivative : derivative(s_, z_, mode_);
  }

  void switch_mode(EventFunction why, bool at_once) {
    if (at_once) ++chattering_;
    const bool was_gripping = mode_ == ContactMode::grips;
    mode_ = why == EventFunction::hold_forward    ? ContactMode::slips_forward
            : why == EventFunction::hold_backward ? ContactMode::slips_backward
                                                  : ContactMode::grips;
    // Without a dashpot the stretch follows from the friction: rounding is not accumulated.
    if (s_.ct == 0.0 && mode_ != ContactMode::grips)
      z_[kStretch] = direction(mode_) * s_.mu * s_.normal_force(z_) / s_.kt;
    derivative_ = derivative(s_, z_, mode_);
    ++evaluations_;
    if (!was_gripping && !first_grip_) first_grip_ = tau_;
    add(was_gripping ? ContactEventKind::slip : ContactEventKind::grip, tau_);
  }

  /// Records extrema and sign changes within the step shortened to `size`.
  void record_extrema(const DenseStep& dense, double size, const State& end) {
    if (const auto at = find_sign_change(dense, EventFunction::depth_rate, size, end, -1)) {
      depth_time_ = tau_ + *at;
      depth_ = dense.at(*at)[kDepth];
      add(ContactEventKind::deepest, depth_time_);
    }
    if (const auto at = find_sign_change(dense, EventFunction::force_rate, size, end, -1))
      update_force_max(dense.at(*at), tau_ + *at, true);
    if (const auto at = find_sign_change(dense, EventFunction::friction_rate, size, end, 0))
      friction_max_ = std::max(friction_max_, std::abs(s_.friction(dense.at(*at), mode_)));
    if (!slip_zero_) {
      if (const auto at = find_sign_change(dense, EventFunction::slip, size, end, 0)) slip_zero_ = tau_ + *at;
    }
    if (mode_ != ContactMode::grips) return;
    if (const auto at = find_sign_change(dense, EventFunction::friction, size, end, 0)) {
      ++reversals_;
      add(ContactEventKind::friction_reversal, tau_ + *at);
    }
  }

  void update_force_max(const State& z, double tau, bool turning_point) {
    const double force = s_.normal_force(z);
    if (turning_point) add(ContactEventKind::largest_force, tau);
    if (force <= force_max_) return;
    force_max_ = force;
    force_time_ = tau;
  }

  void add(ContactEventKind kind, double tau) { add_event(noted_, {tau / s_.frequency_radps, kind}); }

  ContactSummary summary() const;
  [[maybe_unused]] bool is_consistent(const ContactSummary& summary) const;

  const System& s_;
  double tolerance_;
  std::vector<ContactStep>* stored_;
  ContactMode mode_;
  State z_{};
  State derivative_{};
  State end_{};
  State scale_{};
  double tau_ = 0.0;
  double size_ = 0.0;
  double next_size_ = 0.0;
  bool released_ = false;
  bool full_ = false;  ///< the depth is past the radius: the footprint has its largest size
  bool started_gripping_ = false;
  int chattering_ = 0;
  int steps_ = 0;
  int evaluations_ = 1;
  int reversals_ = 0;
  ContactSummary noted_;  ///< its events
  std::optional<double> first_grip_;
  std::optional<double> slip_zero_;
  double depth_ = 0.0;
  double depth_time_ = 0.0;
  double force_max_ = 0.0;
  double force_time_ = 0.0;
  double friction_max_ = 0.0;
};

ContactSummary ContactIntegrator::summary() const {
  const double second = 1.0 / s_.frequency_radps, metre = s_.speed_mps * second;
  const double newton = s_.mass_kg * s_.speed_mps * s_.frequency_radps;
  const double joule = s_.mass_kg * s_.speed_mps * s_.speed_mps;
  const double normal_impulse = 1.0 - z_[kDepthRate];
  ContactSummary out = noted_;
  static_cast<ContactLiftOff&>(out) = lift_off_of(s_, z_, tau_);
  out.method = ContactMethod::dormand_prince;
  if (slip_zero_) out.slip_zero_s = *slip_zero_ * second;
  if (started_gripping_ && slip_zero_ && (!first_grip_ || *slip_zero_ < *first_grip_))
    out.skid_to_grip_s = 0.0;
  else if (first_grip_)
    out.skid_to_grip_s = *first_grip_ * second;
  out.regime = out.skid_to_grip_s || out.slip_zero_s ? Regime::grips : Regime::slides;
  out.friction_reversals = reversals_;
  out.max_depth_m = depth_ * metre;
  out.max_depth_time_s = depth_time_ * second;
  out.max_force_n = force_max_ * newton;
  out.max_force_time_s = force_time_ * second;
  out.max_friction_n = friction_max_ * newton;
  out.slip_lo_mps = s_.speed_mps * s_.slip(z_);
  out.impulse_ratio = (0.0 - z_[kVxChange]) / normal_impulse;
  out.mean_offset_m = s_.radius_m * z_[kOffsetImpulse] / normal_impulse;
  out.energy = energy_at_release(s_, z_, tau_);
  out.energy.normal_damping_j = joule * z_[kDampingLoss];
  out.energy.sliding_j = joule * z_[kSlidingLoss];
  out.energy.tangential_damping_j = joule * z_[kTangentialLoss];
  out.energy.offset_j = joule * z_[kOffsetLoss];
  out.steps = steps_;
  out.evaluations = evaluations_;
  assert(is_consistent(out));
  return out;
}

/// Events are in order of time, and no loss of energy is negative beyond the tolerance of its scale. With a
/// constant offset losses are not bounded.
bool ContactIntegrator::is_consistent(const ContactSummary& summary) const {
  // Speeds and the normal force are in units of the touchdown's, so each is known to some roundings of 1; the
  // energy of such an error, and of what it stretches the tangential spring by.
  const double rounded_energy = 1.3e-29 * (1.0 + s_.mu * s_.mu / s_.kt);  // (16 · 2.2e-16)²
  const auto events = summary.event_list();
  const bool sorted =
      std::is_sorted(events.begin(), events.end(),
                     [](const ContactEvent& a, const ContactEvent& b) { return a.time_s < b.time_s; });
  if (!sorted || events.empty() || events.back().kind != ContactEventKind::release) return false;
  if (s_.ahead != 0.0) return true;
  for (const Component loss : {kDampingLoss, kSlidingLoss, kTangentialLoss, kOffsetLoss})
    if (z_[loss] * scale_[loss] < -10.0 / kSafety && z_[loss] < -rounded_energy) return false;
  return true;
}

}  // namespace

tl::expected<ContactSummary, InputError> integrate(const System& system, const ContactOptions& options,
                                                   std::vector<ContactStep>* steps) {
  if (!(options.tolerance >= 1e-12 && options.tolerance <= 1e-3))
    return tl::unexpected(InputError::tolerance_out_of_range);
  // What collocation gives up is hard for steps as well, which may miss how sharply an offset turns round.
  const double tolerance = options.method == ContactMethod::collocation ? 1e-12 : options.tolerance;
  return ContactIntegrator(system, tolerance, steps).integrate_to_release();
}

}  // namespace strobe::impact::detail
