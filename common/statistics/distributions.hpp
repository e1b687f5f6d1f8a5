// Student's t, central and not, chi-squared and Fisher's F. Degrees of freedom are above 0 and need not be
// whole (Welch-Satterthwaite); those of Student's t may be infinite. Pure functions; thread-safe, real-time
// safe.
#pragma once

namespace strobe::statistics {

/// Degrees of freedom; with more, Student's t is taken as normal.
inline constexpr double kAsGoodAsNormal = 1e6;
/// Probability of a normal distribution above mean + sd.
inline constexpr double kAboveOneSd = 0.158655253931457;

/// t that is exceeded with the probability `above`, in (0, 0.5].
double student_t_quantile(double degrees_of_freedom, double above);

/// How many estimated sd hold 68.27 % of the deviations: 1 for infinitely many degrees of freedom, 1.84 for
/// one.
double student_t_sigma(double degrees_of_freedom);

/// The same for `share` of the deviations, 0 to 1.
double student_t_half_width(double share, double degrees_of_freedom);

/// Probability that |t| exceeds the given value.
double student_t_tail(double t, double degrees_of_freedom);

/// Probability that (z + shift) / sqrt(q / degrees_of_freedom), z normal and q chi-squared, exceeds t > 0:
/// the noncentral t. Degrees of freedom may be infinite.
double noncentral_t_tail(double t, double degrees_of_freedom, double shift);

/// Sum of squares that is not reached with the probability `below`, in (0, 1).
double chi_squared_quantile(double degrees_of_freedom, double below);

/// Probability that a sum of squares exceeds the given one, above 0.
double chi_squared_tail(double sum_of_squares, double degrees_of_freedom);

/// Probability that the ratio of two mean squares with these degrees of freedom, finite, exceeds `ratio`.
double f_tail(double ratio, double upper_degrees, double lower_degrees);

}  // namespace strobe::statistics
