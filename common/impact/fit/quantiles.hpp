// Student's t, chi-squared and Fisher's F. Degrees of freedom are above 0 and need not be whole. Pure; thread-safe.
#pragma once

namespace strobe::impact {

inline constexpr double kAsGoodAsNormal = 1e6;  ///< degrees of freedom
inline constexpr double kAboveOneSd =
    0.158655253931457;  ///< probability of a normal distribution above mean + sd

/// t that is exceeded with the probability `above`, in (0, 0.5].
double students_t_quantile(double degrees_of_freedom, double above);

/// Sum of squares of so many degrees of freedom that is not reached with the probability `below`, in (0, 1).
double chi_squared_quantile(double degrees_of_freedom, double below);

/// Probability that the ratio of two mean squares with these degrees of freedom exceeds `ratio`.
double f_tail(double ratio, double upper_degrees, double lower_degrees);

}  // namespace strobe::impact
