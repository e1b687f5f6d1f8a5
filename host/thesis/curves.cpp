#include "host/thesis/curves.hpp"

#include <array>
#include <cmath>

#include "common/units/angles.hpp"
#include "host/thesis/thesis_inputs.hpp"

namespace strobe::thesis {

namespace {

using figures::kNoValue;
using figures::PlotPoint;

using contact::SpinPulse;
using contact::SpinPulseInput;
using data::ContactRow;

using contact::DerivedState;
using contact::SpinPulseState;

/// What is drawn of a quantity, and where integration and differentiation have it.
struct Drawn {
  const char* axis;
  const char* narrow;
  double SpinPulseState::*integrated;
  std::optional<ValueSd> DerivedState::*derived;
  double unit;
};

/// In the order of Quantity.
constexpr std::array<Drawn, 9> kDrawn{{
    {"distance along the surface x, cm", nullptr, &SpinPulseState::x_m, &DerivedState::x_m, 1e2},
    {"height of the top less that at touchdown y, mm", nullptr, &SpinPulseState::y_m, &DerivedState::y_m,
     1e3},
    {"rotation since touchdown, degrees", nullptr, &SpinPulseState::rotation_rad, &DerivedState::rotation_rad,
     degrees(1.0)},
    {"velocity along the surface vx, m/s", "vx, m/s", &SpinPulseState::vx_mps, &DerivedState::vx_mps, 1.0},
    {"velocity normal to it vy, m/s", "vy, m/s", &SpinPulseState::vy_mps, &DerivedState::vy_mps, 1.0},
    {"spin omega, rad/s", "spin, rad/s", &SpinPulseState::omega_radps, &DerivedState::omega_radps, 1.0},
    {"slip vx + R omega, m/s", nullptr, &SpinPulseState::slip_mps, &DerivedState::slip_mps, 1.0},
    {"friction force Fx, N", "Fx, N", &SpinPulseState::fx_n, &DerivedState::fx_n, 1.0},
    {"normal force Fy, N", "Fy, N", &SpinPulseState::fy_n, &DerivedState::fy_n, 1.0},
}};

const Drawn& drawn(Quantity quantity) { return kDrawn[static_cast<std::size_t>(quantity)]; }

double state_value(const SpinPulseState& s, Quantity quantity) {
  return drawn(quantity).unit * s.*drawn(quantity).integrated;
}

/// A fraction of the images in the figures' units; nothing for what images do not show.
std::optional<double> image_value(const SetCurves& c, const ContactRow& row, Quantity quantity) {
  if (quantity == Quantity::x_cm) return row.x_fraction * c.condition->dwell_distance_cm.mean;
  if (quantity == Quantity::y_mm) return 1e3 * row.y_fraction * c.scale.diameter_m;
  if (quantity == Quantity::rotation_deg && row.rotation_fraction)
    return degrees(*row.rotation_fraction * c.scale.total_rotation_rad);
  return std::nullopt;
}

const std::optional<contact::CubicFit>& fit_of(const SetCurves& c, Quantity quantity) {
  if (quantity == Quantity::x_cm) return c.fits.x;
  return quantity == Quantity::y_mm ? c.fits.y : c.fits.rotation;
}

double cubic_value(const SetCurves& c, double t, Quantity quantity) {
  const auto& fit = fit_of(c, quantity);
  if (!fit) return kNoValue;
  const double value = fit->value(t);
  return image_value(c, ContactRow{t, value, value, value}, quantity).value_or(kNoValue);
}

/// Value and sd of differentiation in the figures' units.
PlotPoint derived_point(const DerivedState& state, Quantity quantity, bool band) {
  const std::optional<ValueSd>& v = state.*drawn(quantity).derived;
  if (!v) return {0.0, kNoValue};
  const double y = drawn(quantity).unit * v->value;
  const double sd = band ? drawn(quantity).unit * v->sd : kNoValue;
  return {0.0, y, y - sd, y + sd};
}

using Motion = std::function<contact::SpinPulseState(double)>;

/// Integration as a function of the time fraction; nothing for inputs out of range.
std::optional<Motion> motion_of(const SpinPulseInput& input, bool grips) {
  if (grips) {
    const auto pulse = SpinPulse::make(input);
    if (!pulse) return std::nullopt;
    return [p = *pulse](double t) { return p.at_fraction(t); };
  }
  const auto pulse = impact::SinePulse::make(input.form, {.vx_td_mps = input.touchdown.vx_mps,
                                                          .vy_td_mps = input.touchdown.vy_mps,
                                                          .e = input.e,
                                                          .impulse_ratio = input.mu,
                                                          .dwell_s = input.dwell_s,
                                                          .mass_kg = input.ball.mass_kg});
  if (!pulse) return std::nullopt;
  return [p = *pulse](double t) {
    const impact::PulseState s = p.at_fraction(t);
    contact::SpinPulseState out;
    out.x_m = s.x_m;
    out.y_m = s.y_m;
    out.vx_mps = s.vx_mps;
    out.vy_mps = s.vy_mps;
    out.fx_n = s.fx_n;
    out.fy_n = s.fy_n;
    return out;
  };
}

/// Sd of a quantity at each step from the printed sds, as independent: a central difference over each.
class Propagation {
 public:
  Propagation(const SetCurves& c, const SpinPulseInput& input, bool grips) {
    const contact::SpinPulseSd sd = contact::spin_pulse_sd(*c.condition);
    const auto add = [this, &input, grips](auto change, double size) {
      SpinPulseInput up = input;
      SpinPulseInput down = input;
      change(up, size);
      change(down, -size);
      up.e = std::min(up.e, 1.0);
      up.mu = std::max(up.mu, 0.0);
      down.mu = std::max(down.mu, 0.0);
      auto a = motion_of(up, grips);
      auto b = motion_of(down, grips);
      if (a && b) pairs_.emplace_back(*std::move(a), *std::move(b));
    };
    add([](SpinPulseInput& in, double d) { in.touchdown.vx_mps += d; }, sd.vx_mps);
    add([](SpinPulseInput& in, double d) { in.touchdown.vy_mps += d; }, sd.vy_mps);
    add([](SpinPulseInput& in, double d) { in.touchdown.omega_radps += d; }, sd.omega_radps);
    add([](SpinPulseInput& in, double d) { in.e += d; }, sd.e);
    add([](SpinPulseInput& in, double d) { in.mu += d; }, sd.mu);
    add([](SpinPulseInput& in, double d) { in.dwell_s += d; }, sd.dwell_s);
  }

  double sd(double t, Quantity quantity) const {
    double variance = 0.0;
    for (const auto& [up, down] : pairs_) {
      const double half = (state_value(up(t), quantity) - state_value(down(t), quantity)) / 2.0;
      variance += half * half;
    }
    return std::sqrt(variance);
  }

 private:
  std::vector<std::pair<Motion, Motion>> pairs_;
};

double residual_sd(const SetCurves& c, Quantity quantity) {
  double squares = 0.0;
  int n = 0;
  for (const ContactRow& row : c.set->rows) {
    const auto value = image_value(c, row, quantity);
    if (!value) continue;
    squares += std::pow(*value - cubic_value(c, row.time_fraction, quantity), 2);
    ++n;
  }
  return n > 4 ? std::sqrt(squares / (n - 4)) : kNoValue;
}

}  // namespace

const char* axis_label(Quantity quantity) { return drawn(quantity).axis; }

bool is_rotational(Quantity quantity) {
  return quantity == Quantity::rotation_deg || quantity == Quantity::omega_radps ||
         quantity == Quantity::slip_mps;
}

const char* short_label(Quantity quantity) {
  return drawn(quantity).narrow ? drawn(quantity).narrow : axis_label(quantity);
}

Result<SetCurves> set_curves(const ThesisInputs& inputs, const std::string& set) {
  SetCurves c;
  c.condition = inputs.used.condition(set);
  if (!c.condition) return fail("no set " + set);
  c.set = &inputs.used.contact.at(set);
  c.dwell_ms = c.condition->dwell_time_ms.mean;
  c.fits = contact::fit_fractions(*c.set);
  c.scale = contact_scale(inputs, *c.condition);
  if (auto spline = contact::fit_constrained_motion(*c.set, c.scale, contact::end_velocities(*c.condition)))
    c.spline = *std::move(spline);
  c.mechanics = simulate_contact(inputs, *c.condition);
  return c;
}

std::vector<PlotPoint> measured(const SetCurves& c, Quantity quantity) {
  const double sd = residual_sd(c, quantity);
  std::vector<PlotPoint> points;
  for (const ContactRow& row : c.set->rows) {
    const auto value = image_value(c, row, quantity);
    if (!value || data::is_end_point(row)) continue;
    points.push_back({row.time_fraction * c.dwell_ms, *value, *value - sd, *value + sd});
  }
  return points;
}

std::vector<PlotPoint> measured_ends(const SetCurves& c, Quantity quantity) {
  const thesis::Condition& m = *c.condition;
  const double radius_m = c.scale.diameter_m / 2.0;
  const auto slip = [radius_m](const thesis::MeanSd& vx, const thesis::MeanSd& omega) {
    return thesis::MeanSd{vx.mean + radius_m * omega.mean, std::hypot(vx.sd, radius_m * omega.sd)};
  };
  thesis::MeanSd td;
  thesis::MeanSd lo;
  switch (quantity) {
    case Quantity::vx_mps:
      td = m.vx_td_mps;
      lo = m.vx_lo_mps;
      break;
    case Quantity::vy_mps:
      td = m.vy_td_mps;
      lo = m.vy_lo_mps;
      break;
    case Quantity::omega_radps:
      td = m.omega_td_radps;
      lo = m.omega_lo_radps;
      break;
    case Quantity::slip_mps:
      td = slip(m.vx_td_mps, m.omega_td_radps);
      lo = slip(m.vx_lo_mps, m.omega_lo_radps);
      break;
    default:
      return {};
  }
  return {{0.0, td.mean, td.mean - td.sd, td.mean + td.sd},
          {c.dwell_ms, lo.mean, lo.mean - lo.sd, lo.mean + lo.sd}};
}

namespace {

std::vector<PlotPoint> differentiated(const SetCurves& c, Approach approach, Quantity quantity, bool band) {
  if (approach == Approach::spline && !c.spline) return {};
  std::vector<PlotPoint> points;
  for (int i = 0; i <= kCurveSteps; ++i) {
    const double t = static_cast<double>(i) / kCurveSteps;
    const contact::DerivedState state =
        approach == Approach::spline ? contact::derive(*c.spline, t) : contact::derive(c.fits, c.scale, t);
    PlotPoint p = derived_point(state, quantity, band);
    p.x = t * c.dwell_ms;
    points.push_back(p);
  }
  return points;
}

/// Up to the release, which is the dwell time that the spring was made for.
std::vector<PlotPoint> by_mechanics(const SetCurves& c, Quantity quantity) {
  if (!c.mechanics) return {};
  std::vector<PlotPoint> points;
  for (int i = 0; i <= kCurveSteps; ++i) {
    const double time_s = c.mechanics->summary().dwell_s * i / kCurveSteps;
    const impact::ContactState s = c.mechanics->at(time_s);
    const contact::SpinPulseState state{s.x_m,         s.y_m,      s.rotation_rad, s.vx_mps, s.vy_mps,
                                        s.omega_radps, s.slip_mps, s.fx_n,         s.fy_n};
    points.push_back({1e3 * time_s, state_value(state, quantity)});
  }
  return points;
}

std::vector<PlotPoint> integrated(const SetCurves& c, Approach approach, Quantity quantity, bool band) {
  const bool grips = approach == Approach::pulse_grip;
  if (is_rotational(quantity) && !grips) return {};
  const SpinPulseInput input = contact::spin_pulse_input(*c.condition, approach == Approach::pulse_simplified
                                                                           ? impact::PulseForm::simplified
                                                                           : impact::PulseForm::exact);
  const auto motion = motion_of(input, grips);
  if (!motion) return {};
  const Propagation spread(c, input, grips);
  std::vector<PlotPoint> points;
  for (int i = 0; i <= kCurveSteps; ++i) {
    const double t = static_cast<double>(i) / kCurveSteps;
    PlotPoint p{t * c.dwell_ms, state_value((*motion)(t), quantity)};
    if (band) {
      const double sd = spread.sd(t, quantity);
      p.low = p.y - sd;
      p.high = p.y + sd;
    }
    points.push_back(p);
  }
  return points;
}

}  // namespace

std::vector<PlotPoint> curve(const SetCurves& c, Approach approach, Quantity quantity, bool band) {
  if (approach == Approach::cubic || approach == Approach::spline)
    return differentiated(c, approach, quantity, band);
  if (approach == Approach::mechanics) return by_mechanics(c, quantity);
  return integrated(c, approach, quantity, band);
}

}  // namespace strobe::thesis
