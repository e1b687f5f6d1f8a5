#include "host/digitize/outline/outline_sd.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::digitize {

namespace {

// What no residual shows, as images of one leg are off alike. A blurred edge includes more of the ball's
// shaded side, which the profile models less well: an error of the order sigma²/radius (the profile is
// sampled sigma deep, and shading goes as depth over radius), by 1 to 2 of which the centres of whole legs
// are off on rendered photographs with blurs of 1 to 4 px.
constexpr double kMisfit = 1.5;
// By which law light falls towards the limb is known from one lit sphere to the next within 5 % of what it
// adds over a blur's width, beside the step at the limb; the next term of its expansion, which grows as the
// depth that is sampled over the radius to the power of 1.5, within .45 of that; and all within a hundredth
// of a px, as cloth has no sharp edge: rms of the mean error of a photograph's radii, both renderers, blurs
// of 0 to 5 px, balls of 40 to 500 px.
constexpr double kLimbShare = 0.05;
constexpr double kShading = 0.45;
constexpr double kFloor_px = 0.01;
// Of the error that sectors beside a terminator share, what all of them are off inwards, and what varies as
// the cosine or sine of their direction: as balls of which one lamp lights half have it, on 8 rendered
// photographs.
constexpr double kTerminator = 1.5, kAcross = 0.5;
// What a ball moves by while its flash lasts smears its limbs ahead and behind. Where the light was uneven,
// with a tail or a second discharge, each limb seems nearer to where most of it was. By how much the blur
// grows there tells little of how uneven it was: of second discharges of a twentieth to a fifth, 1 to 2 px
// on, limbs are off by one to four times that, of larger ones by less, and by no more than some tenth of the
// blur. Lamps from two sides alone make limbs seem blurred unevenly by 2 %, on rendered photographs.
constexpr double kUneven = 1.5, kMaxUneven = 0.1, kByLamps = 0.02;

using Vector = OutlineVector;
using Square = OutlineMatrix;

/// How much larger correlation along the outline makes the variance of what many sectors tell: (1 + r)/(1 -
/// r) where neighbours' residuals are correlated by r and those farther apart by its powers. The fit absorbs
/// what changes slowly, so that its own residuals are correlated less (Andrews and Monahan 1992).
///
/// Where the photograph's border cuts an outline, so few independent sectors are left that they know their
/// own scatter badly: the variance of Student's t. The arcs that other images leave are judged among those
/// images, with odds that were learnt on sds without it.
double variance_by_correlation(const FittedSectors& sectors) {
  constexpr double kMaxCorrelation = 0.6;  // more is not told by as few sectors as an arc has
  constexpr double kMinFreedom = 2.67;     // below, t has hardly a variance: twice the sd
  const std::vector<double>& weight = sectors.offsets.weight;
  double squares = 0.0, products = 0.0, count = 0.0, pairs = 0.0;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    const std::size_t next = (i + 1) % weight.size();
    if (weight[i] <= 0.0) continue;
    squares += weight[i] * sectors.residuals[i] * sectors.residuals[i];
    count += 1.0;
    if (weight[next] <= 0.0) continue;
    products += std::sqrt(weight[i] * weight[next]) * sectors.residuals[i] * sectors.residuals[next];
    pairs += 1.0;
  }
  if (!(squares > 0.0)) return 1.0;
  const double seen = pairs > 0.0 ? products / pairs * count / squares : 0.0;
  const double told_by = sectors.cut_off ? count : static_cast<double>(weight.size());
  const double absorbed = kOutlineParameters / (told_by + kOutlineParameters);
  const double correlation = std::clamp(seen + absorbed, 0.0, kMaxCorrelation);
  const double alike = (1.0 + correlation) / (1.0 - correlation);
  if (!sectors.cut_off) return alike;
  const double freedom = std::max(kMinFreedom, count / alike - kOutlineParameters);
  return alike * freedom / (freedom - 2.0);
}

/// By how much the outline moves where each sector is off by `off(i)` px.
template <typename Off>
Vector moved_by(const FittedSectors& sectors, const Square& inverse, const Off& off) {
  Vector pull{};
  for (std::size_t i = 0; i < sectors.gradients.size(); ++i)
    pull += sectors.offsets.weight[i] * off(i) * sectors.gradients[i];
  return inverse * pull;
}

/// Means over the outline, as its sectors are weighted.
struct LimbLight {
  double step = 0.0;      ///< of light at the limb
  double rounding = 0.0;  ///< what its curvature adds over a blur's width

  double ratio() const { return rounding > 0.0 ? std::min(1.0, rounding / std::max(step, 1e-12)) : 0.0; }
};

LimbLight limb_light(const SectorOffsets& offsets) {
  LimbLight light;
  double weights = 1e-12;
  for (std::size_t i = 0; i < offsets.edges.size(); ++i) {
    light.step += offsets.weight[i] * offsets.edges[i].step;
    light.rounding += offsets.weight[i] * offsets.edges[i].rounding;
    weights += offsets.weight[i];
  }
  return {light.step / weights, light.rounding / weights};
}

/// How far uneven light may move the centre, px: along the direction in which the limbs are blurred most.
/// What they are more or less than their mean goes as the cosine of twice the direction.
cv::Vec2d smear_sd(const FittedSectors& sectors) {
  const double sigma = sectors.sigma_px;
  cv::Matx33d normal = cv::Matx33d::eye() * (4.0 / (sigma * sigma));  // half the blur, or less
  cv::Vec3d right;
  for (std::size_t i = 0; i < sectors.gradients.size(); ++i) {
    const SectorEdge& edge = sectors.offsets.edges[i];
    const cv::Vec3d way(1.0, sectors.gradients[i][3], sectors.gradients[i][4]);
    normal += sectors.offsets.robust[i] * edge.sigma_weight * way * way.t();
    right += sectors.offsets.robust[i] * edge.sigma_change * way;
  }
  const cv::Vec3d more = normal.solve(right, cv::DECOMP_CHOLESKY);
  const double by_lamps = kByLamps * sigma;
  const double smear2 = more[1] * more[1] + more[2] * more[2] - by_lamps * by_lamps;
  const double moved = std::min(kUneven * std::sqrt(std::max(0.0, smear2)), kMaxUneven * sigma);
  const double direction = 0.5 * std::atan2(more[2], more[1]);
  return moved * cv::Vec2d(std::cos(direction), std::sin(direction));
}

}  // namespace

OutlineSd outline_covariance(const FittedSectors& sectors, const OutlineMatrix& prior, double rounding_sd) {
  const std::size_t count = sectors.gradients.size();
  const SectorOffsets& offsets = sectors.offsets;
  Square slope = prior;
  for (std::size_t i = 0; i < count; ++i)
    slope += offsets.sensitivity[i] * sectors.gradients[i] * sectors.gradients[i].t();
  const Square inverse = slope.inv(cv::DECOMP_CHOLESKY);
  Square squares = Square::zeros();
  for (std::size_t i = 0; i < count; ++i) {
    const Vector& g = sectors.gradients[i];
    // Corrects the residual for its own leverage.
    const double leverage = std::min(0.7, offsets.weight[i] * g.dot(inverse * g));
    const Vector score = offsets.weight[i] * sectors.residuals[i] / (1.0 - leverage) * g;
    squares += score * score.t();
  }
  OutlineSd sd;
  sd.covariance = inverse * (prior + squares * variance_by_correlation(sectors)) * inverse;
  // Errors that adjacent sectors share beside a shadow are hardly shared across the ball; but the terminator
  // lies further in on all sides, of all the photograph's balls alike.
  for (const int across : {0, 1}) {
    const Vector moved = moved_by(sectors, inverse, [&](std::size_t i) {
      return kAcross * offsets.common_sd[i] * sectors.gradients[i][across];
    });
    sd.covariance += moved * moved.t();
  }
  const Vector shadow =
      moved_by(sectors, inverse, [&](std::size_t i) { return kTerminator * offsets.common_sd[i]; });
  sd.covariance += shadow * shadow.t();
  const LimbLight light = limb_light(offsets);
  const double misfit = kMisfit * sectors.sigma_px * sectors.sigma_px / sectors.radius_px;
  const double limb = kLimbShare * sectors.sigma_px * light.ratio();
  const double rounding = sectors.sigma_px * rounding_sd / std::max(light.step + light.rounding, rounding_sd);
  const double shading = kShading * sectors.sigma_px * std::pow(sectors.depth_px / sectors.radius_px, 1.5);
  const double floor = std::hypot(std::hypot(kFloor_px, rounding), std::hypot(limb, shading));
  for (int a = 0; a < 2; ++a) sd.covariance(a, a) += misfit * misfit;
  const cv::Vec2d smear = smear_sd(sectors);
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b) sd.covariance(a, b) += smear[a] * smear[b];
  sd.covariance(2, 2) += floor * floor;
  sd.shared_radius_px = std::hypot(floor, shadow[2]);
  return sd;
}

}  // namespace strobe::digitize
