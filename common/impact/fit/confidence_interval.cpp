#include "common/impact/fit/confidence_interval.hpp"

#include <algorithm>
#include <cmath>

#include "common/impact/fit/regula_falsi.hpp"

namespace strobe::impact {

namespace {

constexpr double kTolerance = 5e-3;  ///< of an end, in sds

/// How many sds the best fit under a value of the parameter is worse than the best of all, less `t`.
class Profile {
 public:
  Profile(const Fitter& least, Parameter parameter, double unit, double t)
      : fitter_(least), parameter_(parameter), least_(least.chi2()), unit_(unit), t_(t) {}

  double operator()(double value) {
    fitter_ = fitter_.with_fixed(parameter_, value);
    fitter_.refine();
    return std::sqrt(std::max(0.0, fitter_.chi2() - least_) / unit_) - t_;
  }

 private:
  Fitter fitter_;
  Parameter parameter_;
  double least_;
  double unit_;
  double t_;
};

/// One end: steps outwards until the profile is above the step, then back to it.
std::optional<double> end_of(Profile profile, double value, double step, double bound, double t) {
  FunctionValue inside{value, -t};
  for (double reach = step; inside.at != bound; reach *= 2.0) {
    const double at = step > 0.0 ? std::min(bound, inside.at + reach) : std::max(bound, inside.at + reach);
    const FunctionValue now{at, profile(at)};
    if (now.value > 0.0) return regula_falsi(profile, inside, now, kTolerance * std::abs(step) / t).at;
    inside = now;
  }
  return std::nullopt;
}

}  // namespace

Interval profile_interval(const Fitter& least, Parameter parameter, double sd, double unit, double t) {
  const double value = least.values()[index(parameter)];
  if (!(unit > 0.0) || !(sd > 0.0)) return {value, value};
  const Profile profile(least, parameter, unit, t);
  const double radius = 0.5 * least.options().diameter_m;
  return {end_of(profile, value, -t * sd, lower_bound(parameter), t),
          end_of(profile, value, t * sd, upper_bound(parameter, radius), t)};
}

}  // namespace strobe::impact
