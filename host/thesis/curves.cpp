#include "host/thesis/curves.hpp"

#include <cmath>

#include "common/units/angles.hpp"

namespace strobe::report {

namespace {

using contact::ContactRow;
using contact::SpinPulse;
using contact::SpinPulseInput;

double state_value(const contact::ContactState& s, Quantity quantity) {
  switch (quantity) {
    case Quantity::x_cm:
      return 1e2 * s.x_m;
    case Quantity::y_mm:
      return 1e3 * s.y_m;
    case Quantity::rotation_deg:
      return degrees(s.rotation_rad);
    case Quantity::vx_mps:
      return s.vx_mps;
    case Quantity::vy_mps:
      return s.vy_mps;
    case Quantity::omega_radps:
      return s.omega_radps;
    case Quantity::slip_mps:
      return s.slip_mps;
    case Quantity::fx_n:
      return s.fx_n;
    case Quantity::fy_n:
      return s.fy_n;
  }
  return kNoValue;
}

/// A fraction of the images in the figures' units; nothing for what images do not show.
std::optional<double> image_value(const SetCurves& c, const ContactRow& row, Quantity quantity) {
  if (quantity == Quantity::x_cm) return row.x_fraction * c.condition->dwell_distance_cm.mean;
  if (quantity == Quantity::y_mm) return 1e3 * row.y_fraction * c.scale.diameter_m;
  if (quantity == Quantity::rotation_deg && row.rotation_fraction)
    return degrees(*row.rotation_fraction * c.total_rotation_rad);
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

double derived_value(const SetCurves& c, double t, Quantity quantity) {
  const contact::DerivedMotion motion = contact::differentiate(c.fits, c.scale, t);
  const auto or_nothing = [](const std::optional<double>& value) { return value.value_or(kNoValue); };
  switch (quantity) {
    case Quantity::vx_mps:
      return or_nothing(motion.vx_mps);
    case Quantity::vy_mps:
      return or_nothing(motion.vy_mps);
    case Quantity::omega_radps:
      return or_nothing(motion.omega_radps);
    case Quantity::slip_mps:
      return or_nothing(motion.vx_mps) + c.scale.diameter_m / 2.0 * or_nothing(motion.omega_radps);
    case Quantity::fx_n:
      return or_nothing(motion.fx_n);
    case Quantity::fy_n:
      return or_nothing(motion.fy_n);
    default:
      return cubic_value(c, t, quantity);
  }
}

/// Sd of a quantity at each step from the printed sds, as independent: a central difference over each.
class Propagation {
 public:
  Propagation(const SetCurves& c, const SpinPulseInput& input) {
    const contact::SpinPulseSd sd = contact::spin_pulse_sd(*c.condition);
    const auto add = [this, &input](auto change, double size) {
      SpinPulseInput up = input;
      SpinPulseInput down = input;
      change(up, size);
      change(down, -size);
      up.e = std::min(up.e, 1.0);
      up.mu = std::max(up.mu, 0.0);
      down.mu = std::max(down.mu, 0.0);
      const auto a = SpinPulse::make(up);
      const auto b = SpinPulse::make(down);
      if (a && b) pairs_.emplace_back(*a, *b);
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
      const double half =
          (state_value(up.at_fraction(t), quantity) - state_value(down.at_fraction(t), quantity)) / 2.0;
      variance += half * half;
    }
    return std::sqrt(variance);
  }

 private:
  std::vector<std::pair<SpinPulse, SpinPulse>> pairs_;
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

const char* axis_label(Quantity quantity) {
  switch (quantity) {
    case Quantity::x_cm:
      return "distance along the surface x, cm";
    case Quantity::y_mm:
      return "height of the top less that at touchdown y, mm";
    case Quantity::rotation_deg:
      return "rotation since touchdown, degrees";
    case Quantity::vx_mps:
      return "velocity along the surface vx, m/s";
    case Quantity::vy_mps:
      return "velocity normal to it vy, m/s";
    case Quantity::omega_radps:
      return "spin omega, rad/s";
    case Quantity::slip_mps:
      return "slip vx + R omega, m/s";
    case Quantity::fx_n:
      return "friction force Fx, N";
    case Quantity::fy_n:
      return "normal force Fy, N";
  }
  return "";
}

Result<SetCurves> set_curves(const Material& material, const std::string& set) {
  SetCurves c;
  c.condition = material.used.condition(set);
  if (!c.condition) return fail("no set " + set);
  c.set = &material.used.contact.at(set);
  c.dwell_ms = c.condition->dwell_time_ms.mean;
  const auto total = contact::end_spin_total(*c.set, c.condition->omega_td_radps.mean,
                                             c.condition->omega_lo_radps.mean, c.dwell_ms / 1e3);
  if (!total) return fail(set + ": " + total.error().message);
  c.total_rotation_rad = total->total_rad;
  c.fits = contact::fit_fractions(*c.set);
  c.scale = {.dwell_time_s = c.dwell_ms / 1e3,
             .dwell_distance_m = c.condition->dwell_distance_cm.mean / 1e2,
             .total_rotation_rad = c.total_rotation_rad};
  return c;
}

std::vector<PlotPoint> measured(const SetCurves& c, Quantity quantity) {
  const double sd = residual_sd(c, quantity);
  std::vector<PlotPoint> points;
  for (const ContactRow& row : c.set->rows) {
    const auto value = image_value(c, row, quantity);
    if (!value || contact::is_end_point(row)) continue;
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

std::vector<PlotPoint> differentiated(const SetCurves& c, Quantity quantity) {
  std::vector<PlotPoint> points;
  for (int i = 0; i <= kCurveSteps; ++i) {
    const double t = static_cast<double>(i) / kCurveSteps;
    points.push_back({t * c.dwell_ms, derived_value(c, t, quantity)});
  }
  return points;
}

std::vector<PlotPoint> integrated(const SetCurves& c, impact::PulseForm form, Quantity quantity, bool band) {
  const SpinPulseInput input = contact::spin_pulse_input(*c.condition, form);
  const auto pulse = SpinPulse::make(input);
  if (!pulse) return {};
  const Propagation spread(c, input);
  std::vector<PlotPoint> points;
  for (int i = 0; i <= kCurveSteps; ++i) {
    const double t = static_cast<double>(i) / kCurveSteps;
    PlotPoint p{t * c.dwell_ms, state_value(pulse->at_fraction(t), quantity)};
    if (band) {
      const double sd = spread.sd(t, quantity);
      p.low = p.y - sd;
      p.high = p.y + sd;
    }
    points.push_back(p);
  }
  return points;
}

}  // namespace strobe::report
