#include "tests/common/contact_ode/reference.hpp"

#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

namespace strobe::testing {

namespace {

enum Part : std::size_t { kY, kRate, kVx, kOmega, kU, kX, kAngle, kParts };
using Vector = std::array<Quad, kParts>;

class Contact {
 public:
  Contact(const ball::Ball& ball, const impact::Motion& td, const impact::ContactCoefficients& c)
      : radius_(Quad(ball.diameter_m) / 2),
        mass_(ball.mass_kg),
        alpha_(ball.alpha),
        mu_(c.mu),
        share_(c.offset_share),
        reference_(c.offset_reference_mps),
        along_(c.gravity_along_mps2) {
    const Quad zeta = reference_damping_ratio(c.e);
    const Quad phase = reference_release_phase(zeta);
    const Quad frequency = phase / Quad(c.dwell_s);
    k_ = mass_ * frequency * frequency;
    c_ = 2 * zeta * mass_ * frequency;
    kt_ = k_ * Quad(c.stiffness_ratio);
    ct_ = Quad(c.damping_ratio) * sqrt(kt_ * mass_);
    dwell_ = Quad(c.dwell_s);
    z_ = {0, -Quad(td.vy_mps), Quad(td.vx_mps), Quad(td.omega_radps), 0, 0, 0};
    const Quad slip = slip_of(z_);
    const Quad held = ct_ * abs(slip);
    const Quad limit = mu_ * force_of(z_);
    // As the dashpot holds; without one, as the forces rise.
    const Quad rise = mu_ * force_rate_of(z_);
    const Quad pull = kt_ * slip + ct_ * along_;
    const bool slips =
        held > limit || (held == limit && abs(pull) > rise) || (mu_ == 0 && slip == 0 && along_ != 0);
    mode_ = !slips ? 0 : (slip != 0 ? slip : along_) < 0 ? -1 : 1;
  }

  ReferenceContact run(int intervals) {
    for (int i = 0; i < intervals; ++i) {
      Quad from = Quad(i) / intervals;
      const Quad to = Quad(i + 1) / intervals;
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
  Quad slip_of(const Vector& z) const { return z[kVx] + radius_ * z[kOmega]; }
  Quad force_of(const Vector& z) const { return k_ * z[kY] + c_ * z[kRate]; }
  Quad force_rate_of(const Vector& z) const { return k_ * z[kRate] - c_ * force_of(z) / mass_; }

  Quad time_of(const Quad& r) const { return dwell_ * (1 - cos(boost::math::constants::pi<Quad>() * r)) / 2; }

  void slopes(const Vector& z, Vector& d, const Quad& r) const {
    const Quad pi = boost::math::constants::pi<Quad>();
    const Quad pace = dwell_ * pi * sin(pi * r) / 2;  // dt/dr
    const Quad normal = force_of(z);
    Quad friction = kt_ * z[kU] + ct_ * slip_of(z);
    Quad stretching = slip_of(z);
    if (mode_ != 0) {
      friction = mode_ * mu_ * normal;
      stretching = ct_ > 0 ? (friction - kt_ * z[kU]) / ct_ : mode_ * mu_ * force_rate_of(z) / kt_;
    }
    Quad depth = z[kY];
    if (depth < 0) depth = 0;
    if (depth > radius_) depth = radius_;
    const Quad turning = radius_ * z[kOmega];
    const Quad offset = -share_ * sqrt(depth * (2 * radius_ - depth)) * turning /
                        sqrt(turning * turning + reference_ * reference_);
    d = {z[kRate] * pace,
         -normal / mass_ * pace,
         (along_ - friction / mass_) * pace,
         (offset * normal - radius_ * friction) / (alpha_ * mass_ * radius_ * radius_) * pace,
         stretching * pace,
         z[kVx] * pace,
         z[kOmega] * pace};
  }

  Vector moved(const Quad& from, const Quad& size) const {
    boost::numeric::odeint::runge_kutta_fehlberg78<Vector, Quad, Vector, Quad,
                                                   boost::numeric::odeint::array_algebra>
        stepper;
    Vector z = z_;
    stepper.do_step([this](const Vector& at, Vector& d, const Quad& r) { slopes(at, d, r); }, z, from, size);
    return z;
  }

  /// Negative where the mode's law is broken; `why` the mode that follows.
  Quad lawful(const Vector& z, int& next) const {
    const Quad limit = mu_ * force_of(z);
    const Quad hold = kt_ * z[kU] + ct_ * slip_of(z);
    if (mode_ == 0) {
      next = hold < 0 ? -1 : 1;
      return limit - abs(hold);
    }
    next = 0;
    if (ct_ > 0) return mode_ * hold - limit;
    return mode_ * slip_of(z) - mu_ * force_rate_of(z) / kt_;
  }

  /// From r = `from` towards `to`, ending where the law changes; returns where.
  Quad step(const Quad& from, const Quad& to, bool last) {
    int next = 0;
    const Vector end = moved(from, to - from);
    const Quad scale =
        mu_ * k_ * abs(z_[kY]) + kt_ * abs(z_[kU]) + ct_ * abs(slip_of(z_)) + mu_ * c_ * abs(z_[kRate]);
    const Quad noise = (mode_ == 0 || ct_ > 0 ? scale : abs(slip_of(z_)) + scale / kt_) * Quad(1e-30);
    const bool deep = z_[kY] > radius_;
    if (share_ > 0 && deep != (end[kY] > radius_) && to - from > Quad(1e-30)) {
      const Quad size = size_to_full_footprint(from, to, deep);
      const Vector full = moved(from, size);
      if (lawful(full, next) < -noise) return to_change(from, size);
      z_ = full;
      return from + size;
    }
    // At release itself everything vanishes together.
    if (lawful(end, next) >= -noise || (last && to - from < Quad(1e-12))) {
      z_ = end;
      return to;
    }
    return to_change(from, to - from);
  }

  /// To where the law, broken `high` further, begins to be.
  Quad to_change(const Quad& from, Quad high) {
    Quad low = 0;
    int next = 0;
    for (int i = 0; i < 100 && high - low > high * Quad(1e-32); ++i) {
      const Quad middle = (low + high) / 2;
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
  Quad size_to_full_footprint(const Quad& from, const Quad& to, bool deep) const {
    Quad low = 0;
    Quad high = to - from;
    for (int i = 0; i < 100; ++i) {
      const Quad middle = (low + high) / 2;
      ((moved(from, middle)[kY] > radius_) == deep ? low : high) = middle;
    }
    return high;
  }

  Quad radius_, mass_, alpha_, mu_, share_, reference_, along_;
  Quad k_, c_, kt_, ct_, dwell_;
  Vector z_{};
  int mode_ = 0;
  ReferenceContact out_;
};

}  // namespace

Quad reference_release_phase(const Quad& zeta) {
  const Quad q = sqrt(1 - zeta * zeta);
  return (boost::math::constants::pi<Quad>() - atan2(2 * zeta * q, 1 - 2 * zeta * zeta)) / q;
}

Quad reference_damping_ratio(const Quad& e) {
  Quad low = 0;
  Quad high = 1 - Quad(1e-30);
  for (int i = 0; i < 115; ++i) {
    const Quad middle = (low + high) / 2;
    (exp(-middle * reference_release_phase(middle)) > e ? low : high) = middle;
  }
  return (low + high) / 2;
}

ReferenceContact reference_contact(const ball::Ball& ball, const impact::Motion& touchdown,
                                   const impact::ContactCoefficients& coefficients, int intervals) {
  return Contact(ball, touchdown, coefficients).run(intervals);
}

}  // namespace strobe::testing
