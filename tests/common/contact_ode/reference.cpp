#include "tests/common/contact_ode/reference.hpp"

#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

namespace strobe::testing {

namespace {

enum Part : std::size_t { kY, kRate, kVx, kOmega, kU, kX, kAngle, kParts };
template <typename Number>
Number release_phase_of(const Number& zeta) {
  const Number q = sqrt(1 - zeta * zeta);
  return (boost::math::constants::pi<Number>() - atan2(2 * zeta * q, 1 - 2 * zeta * zeta)) / q;
}

template <typename Number>
Number damping_ratio_of(const Number& e) {
  Number low = 0;
  Number high = 1 - Number(1e-30);
  for (int i = 0; i < std::numeric_limits<Number>::digits + 2; ++i) {
    const Number middle = (low + high) / 2;
    (exp(-middle * release_phase_of(middle)) > e ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// In units of sqrt(m/k) and of the speed of touchdown: where the force of the damped sine about the weight's depth has
/// gone, near the phase without a weight.
template <typename Number>
Number release_phase_under(const Number& zeta, const Number& weight) {
  const Number q = sqrt(1 - zeta * zeta);
  Number t = release_phase_of(zeta);
  if (weight == 0) return t;
  for (int i = 0; i < 12; ++i) {
    const Number fade = exp(-zeta * t), c = cos(q * t), s = sin(q * t) / q;
    const Number depth = weight + fade * ((1 - weight * zeta) * s - weight * c);
    const Number rate = fade * (c + (weight - zeta) * s);
    const Number force = depth + 2 * zeta * rate;
    t -= force / (rate + 2 * zeta * (weight - force));
  }
  return t;
}

template <typename Number>
class Contact {
  using Vector = std::array<Number, kParts>;

 public:
  explicit Contact(const ReferenceInput<Number>& in)
      : radius_(in.diameter_m / 2),
        alpha_(in.alpha),
        mu_(in.mu),
        share_(in.offset_share),
        reference_(in.offset_reference_mps),
        gravity_(in.gravity_mps2),
        along_(in.gravity_along_mps2) {
    const Number zeta = damping_ratio_of(in.e);
    const Number frequency = release_phase_of(zeta) / in.dwell_s;
    k_ = mass_ * frequency * frequency;
    c_ = 2 * zeta * mass_ * frequency;
    kt_ = k_ * in.stiffness_ratio;
    ct_ = in.damping_ratio * sqrt(kt_ * mass_);
    dwell_ = release_phase_under(zeta, Number(gravity_ / (-in.vy_mps * frequency))) / frequency;
    z_ = {0, -in.vy_mps, in.vx_mps, in.omega_radps, 0, 0, 0};
    const Number slip = slip_of(z_);
    const Number held = ct_ * abs(slip);
    const Number limit = mu_ * force_of(z_);
    // As the dashpot holds; without one, as the forces rise.
    const Number rise = mu_ * force_rate_of(z_);
    const Number pull = kt_ * slip + ct_ * along_;
    const bool slips =
        held > limit || (held == limit && abs(pull) > rise) || (mu_ == 0 && slip == 0 && along_ != 0);
    mode_ = !slips ? 0 : (slip != 0 ? slip : along_) < 0 ? -1 : 1;
  }

  ReferenceRelease<Number> run(int intervals) {
    for (int i = 0; i < intervals; ++i) {
      Number from = Number(i) / intervals;
      const Number to = Number(i + 1) / intervals;
      for (int guard = 0; guard < 20 && from < to; ++guard) from = step(from, to, i + 1 == intervals);
    }
    out_.vx_mps = z_[kVx];
    out_.vy_mps = -z_[kRate];
    out_.omega_radps = z_[kOmega];
    out_.dwell_s = dwell_;
    out_.x_m = z_[kX];
    out_.angle_rad = z_[kAngle];
    return out_;
  }

 private:
  Number slip_of(const Vector& z) const { return z[kVx] + radius_ * z[kOmega]; }
  Number force_of(const Vector& z) const { return k_ * z[kY] + c_ * z[kRate]; }
  Number force_rate_of(const Vector& z) const {
    return k_ * z[kRate] + c_ * (gravity_ - force_of(z) / mass_);
  }

  Number time_of(const Number& r) const {
    return dwell_ * (1 - cos(boost::math::constants::pi<Number>() * r)) / 2;
  }

  void slopes(const Vector& z, Vector& d, const Number& r) const {
    const Number pi = boost::math::constants::pi<Number>();
    const Number pace = dwell_ * pi * sin(pi * r) / 2;  // dt/dr
    const Number normal = force_of(z);
    Number friction = kt_ * z[kU] + ct_ * slip_of(z);
    Number stretching = slip_of(z);
    if (mode_ != 0) {
      friction = mode_ * mu_ * normal;
      stretching = ct_ > 0 ? (friction - kt_ * z[kU]) / ct_ : mode_ * mu_ * force_rate_of(z) / kt_;
    }
    Number depth = z[kY];
    if (depth < 0) depth = 0;
    if (depth > radius_) depth = radius_;
    const Number turning = radius_ * z[kOmega];
    const Number offset = -share_ * sqrt(depth * (2 * radius_ - depth)) * turning /
                          sqrt(turning * turning + reference_ * reference_);
    d = {z[kRate] * pace,
         (gravity_ - normal / mass_) * pace,
         (along_ - friction / mass_) * pace,
         (offset * normal - radius_ * friction) / (alpha_ * mass_ * radius_ * radius_) * pace,
         stretching * pace,
         z[kVx] * pace,
         z[kOmega] * pace};
  }

  Vector moved(const Number& from, const Number& size) const {
    boost::numeric::odeint::runge_kutta_fehlberg78<Vector, Number, Vector, Number,
                                                   boost::numeric::odeint::array_algebra>
        stepper;
    Vector z = z_;
    stepper.do_step([this](const Vector& at, Vector& d, const Number& r) { slopes(at, d, r); }, z, from,
                    size);
    return z;
  }

  /// Negative where the mode's law is broken; `why` the mode that follows.
  Number lawful(const Vector& z, int& next) const {
    const Number limit = mu_ * force_of(z);
    const Number hold = kt_ * z[kU] + ct_ * slip_of(z);
    if (mode_ == 0) {
      next = hold < 0 ? -1 : 1;
      return limit - abs(hold);
    }
    next = 0;
    if (ct_ > 0) return mode_ * hold - limit;
    return mode_ * slip_of(z) - mu_ * force_rate_of(z) / kt_;
  }

  /// From r = `from` towards `to`, ending where the law changes; returns where.
  Number step(const Number& from, const Number& to, bool last) {
    int next = 0;
    const Vector end = moved(from, to - from);
    const Number scale =
        mu_ * k_ * abs(z_[kY]) + kt_ * abs(z_[kU]) + ct_ * abs(slip_of(z_)) + mu_ * c_ * abs(z_[kRate]);
    const Number noise = (mode_ == 0 || ct_ > 0 ? scale : abs(slip_of(z_)) + scale / kt_) * Number(1e-30);
    const bool deep = z_[kY] > radius_;
    if (share_ > 0 && deep != (end[kY] > radius_) && to - from > Number(1e-30)) {
      const Number size = size_to_full_footprint(from, to, deep);
      const Vector full = moved(from, size);
      if (lawful(full, next) < -noise) return to_change(from, size);
      z_ = full;
      return from + size;
    }
    // At release itself everything vanishes together.
    if (lawful(end, next) >= -noise || (last && to - from < Number(1e-12))) {
      z_ = end;
      return to;
    }
    return to_change(from, to - from);
  }

  /// To where the law, broken `high` further, begins to be.
  Number to_change(const Number& from, Number high) {
    Number low = 0;
    int next = 0;
    for (int i = 0; i < 100 && high - low > high * Number(1e-32); ++i) {
      const Number middle = (low + high) / 2;
      int unused = 0;
      (lawful(moved(from, middle), unused) >= 0 ? low : high) = middle;
    }
    z_ = moved(from, high);
    lawful(z_, next);
    if (mode_ != 0 && !out_.first_grip_s) out_.first_grip_s = time_of(from + high);
    mode_ = next;
    ++out_.switches;
    if (mode_ != 0 && ct_ == 0) z_[kU] = mode_ * mu_ * force_of(z_) / kt_;
    return from + high;
  }

  /// The footprint's law changes where the depth passes the radius.
  Number size_to_full_footprint(const Number& from, const Number& to, bool deep) const {
    Number low = 0;
    Number high = to - from;
    for (int i = 0; i < 100; ++i) {
      const Number middle = (low + high) / 2;
      ((moved(from, middle)[kY] > radius_) == deep ? low : high) = middle;
    }
    return high;
  }

  Number mass_ = 1;  // all forces are relative to it
  Number radius_, alpha_, mu_, share_, reference_, gravity_, along_;
  Number k_, c_, kt_, ct_, dwell_;
  Vector z_{};
  int mode_ = 0;
  ReferenceRelease<Number> out_;
};

}  // namespace

template <typename Number>
ReferenceInput<Number>::ReferenceInput(const ball::Ball& ball, const impact::Motion& m,
                                       const impact::ContactCoefficients& c)
    : vx_mps(m.vx_mps),
      vy_mps(m.vy_mps),
      omega_radps(m.omega_radps),
      e(c.e),
      dwell_s(c.dwell_s),
      mu(c.mu),
      stiffness_ratio(c.stiffness_ratio),
      damping_ratio(c.damping_ratio),
      offset_share(c.offset_share),
      offset_reference_mps(c.offset_reference_mps),
      gravity_mps2(c.gravity_mps2),
      gravity_along_mps2(c.gravity_along_mps2),
      diameter_m(ball.diameter_m),
      alpha(ball.alpha) {}

template <typename Number>
ReferenceRelease<Number> reference_release(const ReferenceInput<Number>& input, int intervals) {
  return Contact<Number>(input).run(intervals);
}

template struct ReferenceInput<Fifty>;
template ReferenceRelease<Fifty> reference_release(const ReferenceInput<Fifty>& input, int intervals);

Quad reference_release_phase(const Quad& zeta) { return release_phase_of(zeta); }

Quad reference_damping_ratio(const Quad& e) { return damping_ratio_of(e); }

ReferenceContact reference_contact(const ball::Ball& ball, const impact::Motion& touchdown,
                                   const impact::ContactCoefficients& coefficients, int intervals) {
  return reference_release(ReferenceInput<Quad>(ball, touchdown, coefficients), intervals);
}

}  // namespace strobe::testing
