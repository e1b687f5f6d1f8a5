#include "common/impact/fit/coefficient_prior.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace strobe::impact {

namespace {

constexpr double kSolidBallAlpha = 0.4;
constexpr double kMinInside = 1e-9;  ///< of a range, from its end

/// Where `high` is 0 the range has no upper end.
struct Known {
  double low;
  double high;
  double median;
  double sd;
};

constexpr Known known(Parameter p) {
  switch (p) {
    case Parameter::mu:
      return {0.0, 0.0, 0.5, 0.7};
    case Parameter::offset_reference_mps:
      return {0.0, 0.0, 5.0, 1.2};
    case Parameter::damping_ratio:
      return {0.0, 0.0, 0.5, 1.0};
    case Parameter::offset_share:
      return {0.0, 1.0, 0.12, 1.2};
    case Parameter::alpha:
      return {kSolidBallAlpha, ball::kThinShellAlpha, ball::kMeasuredAlpha, 1.5};
    case Parameter::dwell_s:
      return {0.0, 0.0, 4.7e-3, 0.25};
    default:
      return {0.0, 0.0, 1.0, 1.0};  // the stiffness ratio
  }
}

double to_coordinate(const Known& k, double value) {
  if (k.high == 0.0) return std::log(std::max(value, kMinInside * k.median));
  const double inside = kMinInside * (k.high - k.low);
  const double v = std::clamp(value, k.low + inside, k.high - inside);
  return std::log((v - k.low) / (k.high - v));
}

double from_coordinate(const Known& k, double at) {
  if (k.high == 0.0) return std::exp(at);
  return k.low + (k.high - k.low) / (1.0 + std::exp(-at));
}

}  // namespace

std::optional<Prior> prior_of(ReboundModel model, Parameter p) {
  if (model != ReboundModel::ode || !has_parameter(model, p)) return std::nullopt;
  return Prior{to_coordinate(known(p), known(p).median), known(p).sd};
}

double coordinate_of(ReboundModel model, Parameter p, double value) {
  return model == ReboundModel::ode ? to_coordinate(known(p), value) : value;
}

double value_at(ReboundModel model, Parameter p, double coordinate) {
  return model == ReboundModel::ode ? from_coordinate(known(p), coordinate) : coordinate;
}

double slope_at(ReboundModel model, Parameter p, double coordinate) {
  if (model != ReboundModel::ode) return 1.0;
  const Known k = known(p);
  const double value = from_coordinate(k, coordinate);
  return k.high == 0.0 ? value : (value - k.low) * (k.high - value) / (k.high - k.low);
}

double prior_value(Parameter p, double sds) {
  const Known k = known(p);
  return from_coordinate(k, to_coordinate(k, k.median) + sds * k.sd);
}

}  // namespace strobe::impact
