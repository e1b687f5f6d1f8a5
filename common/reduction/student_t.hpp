// Student's t, where a variance was estimated from few residuals. Pure functions; thread-safe, real-time safe.
#pragma once

namespace strobe::reduction {

/// How many estimated sd hold 68.27 % of the deviations: 1 for infinitely many degrees of freedom, 1.84 for
/// one. degrees_of_freedom > 0, need not be whole (Welch-Satterthwaite).
double student_t_sigma(double degrees_of_freedom);

/// The same for `share` of the deviations, 0 to 1.
double student_t_half_width(double share, double degrees_of_freedom);

/// Probability that |t| exceeds the given value.
double student_t_tail(double t, double degrees_of_freedom);

}  // namespace strobe::reduction
