// Adaptive Metropolis: a random walk whose steps follow the covariance of what it has seen (H. Haario, E.
// Saksman and J. Tamminen, Bernoulli 7, 2001), a refused step followed by a shorter one (delayed rejection,
// as in H. Haario, M. Laine, A. Mira and E. Saksman, Statistics and Computing 16, 2006). Several chains from
// points around the start; the first third of each is left out. Deterministic for a seed; thread-safe;
// allocates.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/sampling/sample.hpp"

namespace strobe::sampling {

struct MetropolisOptions {
  std::uint64_t seed = 1;
  int chains = 4;
  int steps = 5000;  ///< of each chain, 60 or more
  Progress progress{};
};

struct MetropolisSample {
  Sample sample;  ///< of all chains, one after the other
  double acceptance = 0.0;
  /// Of each coordinate: independent draws that its mean is worth (C. Geyer, Statistical Science 7, 1992:
  /// initial monotone sequence), and the split R-hat of all chains (Gelman and Rubin), near 1 where they
  /// agree.
  Eigen::VectorXd effective_size;
  Eigen::VectorXd r_hat;
  int evaluations = 0;
};

/// `covariance` is positive definite, that of the first steps; the density at `start` is not 0.
MetropolisSample adaptive_metropolis(const LogDensity& density, const Eigen::VectorXd& start,
                                     const Eigen::MatrixXd& covariance, const MetropolisOptions& options);

/// Independent draws that the mean of the values, a row for each chain, is worth.
double effective_size(const Eigen::MatrixXd& chains);
double split_r_hat(const Eigen::MatrixXd& chains);

}  // namespace strobe::sampling
