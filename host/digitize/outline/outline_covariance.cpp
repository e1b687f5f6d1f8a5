#include "host/digitize/outline/outline_covariance.hpp"

#include <algorithm>
#include <numbers>
#include <vector>

namespace strobe::digitize {

namespace {

// Systematic errors that the sectors' scatter does not show: shading and blur unlike the model shift many
// sectors alike. Both from painted photographs of balls with many looks
// (tests/host/digitize/outlines_test.cpp), the factor also from 721 images on rendered photographs, whose errors are
// then 1.05 sd: a limb that is not of the expected shape moves its neighbours alike.
constexpr double kSdFactor = 1.4;
constexpr double kFloor_px = 0.01;
// A blurred edge includes more of the ball's shaded side, which the profile models less well: an error of the
// order sigma²/radius (the profile is sampled sigma deep, and shading goes as depth over radius), the same
// all around. Rendered photographs show 2 to 3 times it, painted ones less than 1.
constexpr double kMisfit = 1.5;
// Fuzz and shading move all outlines of a photograph in or out alike: 0.025 px of the radius, over 525
// rendered photographs with 25 looks.
constexpr double kLimb_px = 0.025;

using Vector = OutlineVector;
using Square = OutlineMatrix;

Square sensitivity(const FittedSectors& sectors, const Square& prior) {
  Square slope = prior;
  for (std::size_t i = 0; i < sectors.gradients.size(); ++i) {
    const Vector& g = sectors.gradients[i];
    slope += sectors.offsets.sensitivity[i] * g * g.t();
  }
  return slope;
}

}  // namespace

OutlineMatrix outline_covariance(const FittedSectors& sectors, const OutlineMatrix& prior, double sigma_px,
                                 double radius_px) {
  const int count = static_cast<int>(sectors.gradients.size());
  // Sectors with correlated errors: texture and seams reach over a few. A longer window underestimates, as
  // the fit itself absorbs what varies slowly along the outline.
  constexpr int kReach = 3;
  std::vector<Vector> score(static_cast<std::size_t>(count));
  const Square inverse = sensitivity(sectors, prior).inv(cv::DECOMP_CHOLESKY);
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Vector& g = sectors.gradients[at];
    // Corrects the residual for its own leverage.
    const double leverage = std::min(0.7, sectors.offsets.weight[at] * g.dot(inverse * g));
    score[at] = sectors.offsets.weight[at] * sectors.residuals[at] / (1.0 - leverage) * g;
  }
  Square meat = prior;
  for (int i = 0; i < count; ++i) {
    const Vector& here = score[static_cast<std::size_t>(i)];
    meat += here * here.t();
    for (int lag = 1; lag < kReach; ++lag) {
      const Vector& there = score[static_cast<std::size_t>((i + lag) % count)];
      meat += (1.0 - static_cast<double>(lag) / kReach) * (here * there.t() + there * here.t());
    }
  }
  Square covariance = inverse * meat * inverse * (kSdFactor * kSdFactor);
  // Errors that adjacent sectors share are not quite shared across the ball; but the terminator lies further in on all
  // sides.
  for (int pattern = 0; pattern < 3; ++pattern) {
    const double share = pattern == 0 ? 1.0 : 1.0 / std::numbers::sqrt2;
    Vector pull{};
    for (std::size_t i = 0; i < sectors.gradients.size(); ++i) {
      const double along = pattern == 0 ? 1.0 : sectors.gradients[i][pattern - 1];
      pull += sectors.offsets.weight[i] * along * sectors.offsets.common_sd[i] * sectors.gradients[i];
    }
    const Vector moved = inverse * pull * share;
    covariance += moved * moved.t();
  }
  const double misfit = kMisfit * sigma_px * sigma_px / radius_px;
  for (int a = 0; a < 3; ++a) covariance(a, a) += kFloor_px * kFloor_px + misfit * misfit;
  covariance(2, 2) += kLimb_px * kLimb_px;
  return covariance;
}

}  // namespace strobe::digitize
