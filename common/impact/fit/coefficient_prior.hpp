// What is known of the contact mechanics' coefficients before any shot: normal distributions of a coordinate that each
// coefficient may take any value in, the logarithm, or the logit of its place in its range. Weak: 95 % of the prior of mu is
// 0.13…2. A laboratory's shots outweigh it wherever they tell a coefficient at all. Pure; thread-safe, real-time safe.
//
//   coefficient      range       median   sd of the coordinate   95 %               from
//   mu               0…          0.5      0.7 (log)              0.13…2.0           ball on court surfaces: .3 to .9
//   u0               0…          5 m/s    1.2 (log)              0.48…53 m/s        nothing but the size of speeds
//   stiffness_ratio  0…          1        1.0 (log)              0.14…7.1           Mindlin: 2/3 to 1 for a solid sphere
//   damping_ratio    0…          0.5      1.0 (log)              0.07…3.5           critical damping is 2·sqrt(alpha/(1 + alpha))
//   offset_share     0…1         0.12     1.2 (logit)            0.013…0.59         less than the footprint's radius
//   alpha            0.4…2/3     0.55     1.5 (logit)            0.416…0.656        solid ball…thin shell; Cross: 0.55
//   dwell            0…          4.7 ms   0.25 (log)             2.9…7.7 ms         tennis balls on hard surfaces: 4 to 6
#pragma once

#include <optional>

#include "common/impact/fit/rebound_model.hpp"

namespace strobe::impact {

/// Of the coordinate.
struct Prior {
  double mean = 0.0;
  double sd = 1.0;
};

/// Returns nullopt for the closed forms, whose parameters are fitted by the data alone.
std::optional<Prior> prior_of(ReboundModel model, Parameter parameter);

/// The coordinate in which a parameter is fitted; the value itself for the closed forms. A value at the end of its range or
/// beyond counts as just within it.
double coordinate_of(ReboundModel model, Parameter parameter, double value);
double value_at(ReboundModel model, Parameter parameter, double coordinate);
/// Derivative of the value by the coordinate.
double slope_at(ReboundModel model, Parameter parameter, double coordinate);

/// The prior's quantile of the value, `sds` from its median.
double prior_value(Parameter parameter, double sds);

}  // namespace strobe::impact
