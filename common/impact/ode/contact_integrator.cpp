#include "common/impact/ode/contact_integrator.hpp"

#include <algorithm>
#include <limits>

#include "common/impact/ode/event_location.hpp"
#include "common/impact/ode/normal_spring.hpp"

namespace strobe::impact::detail {

namespace {

constexpr int kMaxSteps = 200'000;       // of the adaptive method; fixed steps are as many as asked for
constexpr double kLongest = 400.0;       // about 130 dwell times: gravity holds the ball
constexpr double kUndecidedStep = 1e-7;  // where rounding cannot tell grip from slip
constexpr double kLargestStep = 0.25;
constexpr double kMinScale = 1e-200;  // of a motion that does not take place; its inverse is finite
constexpr double kSafety = 0.1;       // of the tolerance at release that one step may use

class Run {
 public:
  Run(const System& system, const ContactOptions& options, std::vector<ContactStep>* kept)
      : s_(system), options_(options), kept_(kept), mode_(first_mode(system)) {
    z_[kDepthRate] = 1.0;
    started_gripping_ = mode_ == ContactMode::grips;
    fixed_size_ = release_phase(s_.zeta) / options.steps;
    size_ = options.method == ContactMethod::dormand_prince ? std::min(1e-2, first_size()) : fixed_size_;
    set_scales();
    if (kept_) kept_->clear();
    if (s_.slip0 == 0.0) slip_zero_ = 0.0;
    force_max_ = s_.normal_force(z_);
    friction_max_ = std::abs(s_.friction(z_, mode_));
  }

  tl::expected<ContactSummary, InputError> to_release() {
    slope_ = derivative(s_, z_, mode_);
    const int most = adaptive() ? kMaxSteps : std::numeric_limits<int>::max();
    for (int i = 0; i < most; ++i) {
      if (!step()) return tl::unexpected(InputError::too_many_steps);
      if (released_) return summary();
      if (tau_ > kLongest) return tl::unexpected(InputError::no_release);
    }
    return tl::unexpected(InputError::too_many_steps);
  }

 private:
  /// The footprint's radius sets in as a root of time, which no embedded error sees in full: its share of the
  /// first step is kept below the tolerance by the step's size.
  double first_size() const {
    const double smooth = 0.05 * std::pow(options_.tolerance, 0.2);
    if (s_.delta == 0.0) return smooth;
    // That share grows as size^1.5 over the root of the time in which the footprint fills.
    return std::min(smooth,
                    0.2 * std::pow(options_.tolerance, 2.0 / 3.0) * std::cbrt(std::min(1.0, s_.radius)));
  }

  void set_scales() {
    const double offset = s_.delta > 0.0 ? 2.0 * s_.delta * std::sqrt(std::min(1.0, 2.0 / s_.radius)) : 0.0;
    const double tangential = std::max(std::min(2.0 * s_.mu, std::abs(s_.slip0)) + offset, kMinScale);
    const double energy =
        tangential * (std::abs(s_.slip0) + tangential + (offset > 0.0 ? std::abs(s_.w0) : 0.0));
    scale_.fill(tangential);
    scale_[kDepth] = scale_[kDepthRate] = scale_[kDampingLoss] = 1.0;
    scale_[kStretch] = tangential / std::max(1.0, s_.kt);
    scale_[kSlidingLoss] = scale_[kTangentialLoss] = scale_[kOffsetLoss] = std::max(energy, kMinScale);
    for (double& scale : scale_) scale = 1.0 / (scale * kSafety * options_.tolerance);
  }

  bool adaptive() const { return options_.method == ContactMethod::dormand_prince; }

  /// One step, up to the next event if there is one. False: out of events.
  bool step() {
    const double size = attempt();
    TakenStep taken{
        s_,           options_.method, {tau_, size, mode_, z_, slope_}, end_, derivative(s_, end_, mode_),
        &evaluations_};
    ++evaluations_;
    taken.prepare();
    if (size <= kUndecidedStep && undecided_ > 2) {
      undecided_ = 0;
      return advance(taken, size, end_, std::nullopt);
    }
    std::optional<double> first;
    Watched what = Watched::release;
    const auto consider = [&](Watched candidate) {
      const auto at = find_crossing(taken, candidate);
      // The release wins a tie: mu·N and N vanish together.
      if (at && (!first || *at < *first * (1.0 - 1e-13))) {
        first = at;
        what = candidate;
      }
    };
    consider(Watched::release);
    if (mode_ == ContactMode::grips) {
      consider(Watched::hold_forward);
      consider(Watched::hold_backward);
    } else {
      consider(Watched::sliding);
    }
    if (s_.delta > 0.0) consider(full_ ? Watched::footprint_shrinks : Watched::footprint_full);
    if (!first) return advance(taken, size, end_, std::nullopt);
    const bool switches =
        what == Watched::hold_forward || what == Watched::hold_backward || what == Watched::sliding;
    if (*first == 0.0 && switches) return switch_mode(what, true);
    return advance(taken, *first, taken.at(*first), what);
  }

  /// Takes a step into end_ and returns its size.
  double attempt() {
    if (undecided_ > 2) size_ = std::min(size_, kUndecidedStep);
    if (!adaptive()) {
      const double size = undecided_ > 2 ? size_ : fixed_size_;
      end_ = take_step(s_, options_.method, mode_, z_, slope_, size);
      evaluations_ += options_.method == ContactMethod::rk4 ? 3 : 1;
      return size;
    }
    for (;;) {
      State error;
      end_ = take_step_with_error(s_, mode_, z_, slope_, size_, error);
      evaluations_ += 6;
      double worst = 0.0;
      for (std::size_t i = 0; i < kComponents; ++i) worst = std::max(worst, std::abs(error[i]) * scale_[i]);
      const double tried = size_;
      const double factor = worst > 0.0 ? std::clamp(0.9 * std::pow(worst, -0.2), 0.2, 5.0) : 5.0;
      if (worst <= 1.0 || tried <= 1e-14) {
        next_size_ = std::min(tried * factor, kLargestStep);
        return tried;
      }
      size_ = tried * factor;
    }
  }

  bool advance(const TakenStep& taken, double size, const State& end, std::optional<Watched> event) {
    note(taken, size, end);
    if (kept_) {
      kept_->push_back(taken.step);
      kept_->back().size = size;
    }
    ++steps_;
    if (event != Watched::release && tau_ + size > tau_) undecided_ = 0;
    tau_ += size;
    z_ = end;
    force_max_at(z_, tau_, false);
    friction_max_ = std::max(friction_max_, std::abs(s_.friction(z_, mode_)));
    if (adaptive()) size_ = event ? std::max(size_ - size, 0.1 * size_) : next_size_;
    if (event == Watched::release) {
      released_ = true;
      return add(ContactEventKind::release, tau_);
    }
    if (event == Watched::footprint_full || event == Watched::footprint_shrinks)
      full_ = event == Watched::footprint_full;
    else if (event)
      return switch_mode(*event, false);
    slope_ = size == taken.step.size ? taken.end_slope : derivative(s_, z_, mode_);
    return true;
  }

  bool switch_mode(Watched why, bool at_once) {
    if (at_once) ++undecided_;
    const bool was_gripping = mode_ == ContactMode::grips;
    mode_ = why == Watched::hold_forward    ? ContactMode::slips_forward
            : why == Watched::hold_backward ? ContactMode::slips_backward
                                            : ContactMode::grips;
    // Without a dashpot the stretch is the friction's: rounding is not carried on.
    if (s_.ct == 0.0 && mode_ != ContactMode::grips)
      z_[kStretch] = direction(mode_) * s_.mu * s_.normal_force(z_) / s_.kt;
    slope_ = derivative(s_, z_, mode_);
    ++evaluations_;
    if (!was_gripping && !first_grip_) first_grip_ = tau_;
    return add(was_gripping ? ContactEventKind::slip : ContactEventKind::grip, tau_);
  }

  /// Looks for what is noted on the step shortened to `size`.
  void note(const TakenStep& taken, double size, const State& end) {
    if (const auto at = find_sign_change(taken, Watched::depth_rate, size, end, -1)) {
      depth_time_ = tau_ + *at;
      depth_ = taken.at(*at)[kDepth];
      add(ContactEventKind::deepest, depth_time_);
    }
    if (const auto at = find_sign_change(taken, Watched::force_rate, size, end, -1))
      force_max_at(taken.at(*at), tau_ + *at, true);
    if (const auto at = find_sign_change(taken, Watched::friction_rate, size, end, 0))
      friction_max_ = std::max(friction_max_, std::abs(s_.friction(taken.at(*at), mode_)));
    if (!slip_zero_) {
      if (const auto at = find_sign_change(taken, Watched::slip, size, end, 0)) slip_zero_ = tau_ + *at;
    }
    if (mode_ != ContactMode::grips) return;
    if (const auto at = find_sign_change(taken, Watched::friction, size, end, 0)) {
      ++reversals_;
      add(ContactEventKind::friction_reversal, tau_ + *at);
    }
  }

  void force_max_at(const State& z, double tau, bool turning_point) {
    const double force = s_.normal_force(z);
    if (turning_point) add(ContactEventKind::largest_force, tau);
    if (force <= force_max_) return;
    force_max_ = force;
    force_time_ = tau;
  }

  bool add(ContactEventKind kind, double tau) {
    if (event_count_ == kMaxContactEvents) return false;
    const ContactEvent event{tau / s_.frequency_radps, kind};
    // In order of time: what is noted within a step may come before what was noted first.
    auto place = events_.begin() + event_count_++;
    for (; place != events_.begin() && (place - 1)->time_s > event.time_s; --place) *place = *(place - 1);
    *place = event;
    return true;
  }

  ContactSummary summary() const;
  ContactEnergy energy() const;

  const System& s_;
  const ContactOptions& options_;
  std::vector<ContactStep>* kept_;
  ContactMode mode_;
  State z_{};
  State slope_{};
  State end_{};
  State scale_{};
  double tau_ = 0.0;
  double size_ = 0.0;
  double next_size_ = 0.0;
  double fixed_size_ = 0.0;
  bool released_ = false;
  bool full_ = false;  ///< the depth is past the radius: the footprint has its largest size
  bool started_gripping_ = false;
  int undecided_ = 0;
  int steps_ = 0;
  int evaluations_ = 1;
  int reversals_ = 0;
  int event_count_ = 0;
  std::array<ContactEvent, kMaxContactEvents> events_{};
  std::optional<double> first_grip_;
  std::optional<double> slip_zero_;
  double depth_ = 0.0;
  double depth_time_ = 0.0;
  double force_max_ = 0.0;
  double force_time_ = 0.0;
  double friction_max_ = 0.0;
};

ContactEnergy Run::energy() const {
  const double unit = s_.mass_kg * s_.speed_mps * s_.speed_mps;
  const double vy = z_[kDepthRate];
  const double dx = z_[kVxChange];
  const double dw = z_[kSpinChange];
  const double before = 0.5 * (s_.vx0 * s_.vx0 + 1.0 + s_.alpha * s_.w0 * s_.w0);
  const double lost =
      0.5 * (1.0 - vy) * (1.0 + vy) - dx * (s_.vx0 + 0.5 * dx) - s_.alpha * dw * (s_.w0 + 0.5 * dw);
  ContactEnergy e;
  e.kinetic_td_j = unit * before;
  e.kinetic_lo_j =
      unit * 0.5 * ((s_.vx0 + dx) * (s_.vx0 + dx) + vy * vy + s_.alpha * (s_.w0 + dw) * (s_.w0 + dw));
  e.kinetic_lost_j = unit * lost;
  e.normal_damping_j = unit * z_[kDampingLoss];
  e.sliding_j = unit * z_[kSlidingLoss];
  e.tangential_damping_j = unit * z_[kTangentialLoss];
  e.offset_j = unit * z_[kOffsetLoss];
  e.normal_spring_left_j = unit * 0.5 * z_[kDepth] * z_[kDepth];
  e.tangential_spring_left_j = unit * 0.5 * s_.kt * z_[kStretch] * z_[kStretch];
  e.gravity_work_j = unit * s_.gravity * z_[kDepth];
  return e;
}

ContactSummary Run::summary() const {
  const double second = 1.0 / s_.frequency_radps;
  const double metre = s_.speed_mps * second;
  const double newton = s_.mass_kg * s_.speed_mps * s_.frequency_radps;
  const double normal_impulse = 1.0 - z_[kDepthRate];
  ContactSummary out;
  out.lift_off = {s_.speed_mps * (s_.vx0 + z_[kVxChange]), -s_.speed_mps * z_[kDepthRate],
                  s_.speed_mps * (s_.w0 + z_[kSpinChange]) / s_.radius_m};
  out.dwell_s = tau_ * second;
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
  out.dwell_distance_m = metre * (s_.vx0 * tau_ + z_[kPathChange]);
  out.rotation_rad = metre * (s_.w0 * tau_ + z_[kAngleChange]) / s_.radius_m;
  out.slip_lo_mps = s_.speed_mps * s_.slip(z_);
  out.impulse_ratio = (0.0 - z_[kVxChange]) / normal_impulse;
  out.mean_offset_m = s_.radius_m * z_[kOffsetImpulse] / normal_impulse;
  out.energy = energy();
  out.events = events_;
  out.event_count = event_count_;
  out.steps = steps_;
  out.evaluations = evaluations_;
  return out;
}

}  // namespace

tl::expected<ContactSummary, InputError> run(const System& system, const ContactOptions& options,
                                             std::vector<ContactStep>* kept) {
  const bool adaptive = options.method == ContactMethod::dormand_prince;
  if (adaptive && !(options.tolerance >= 1e-12 && options.tolerance <= 1e-3))
    return tl::unexpected(InputError::tolerance_out_of_range);
  if (!adaptive && (options.steps < 4 || options.steps > 10'000'000))
    return tl::unexpected(InputError::tolerance_out_of_range);
  Run contact(system, options, kept);
  return contact.to_release();
}

}  // namespace strobe::impact::detail
