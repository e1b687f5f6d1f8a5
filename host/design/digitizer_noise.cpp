#include "host/design/digitizer_noise.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::host {

namespace {

// Light, over what saturates: of the lightest felt in one image at an exposure of 1, and of felt near the
// limb over the lightest. Edges fade over kFade before they saturate.
constexpr double kLightestFelt = 0.45;
constexpr double kLimb = 0.7;
constexpr double kFade = 0.2;
/// What an edge within other discs tells, over a free one.
constexpr double kCovered = 0.3;

/// Half width of an edge without blur: pixels and fuzz. [px]
constexpr double kSharpEdge_px = 0.3;
constexpr double kUsualDiameter_px = 130.0;
constexpr double kUsualLineWidth = 0.04;

/// A standard deviation: scale · edge^edge_power · (diameter/usual)^diameter_power · readable^readable_power.
struct PowerLaw {
  double scale, edge_power, diameter_power, readable_power;
};

/// Logarithms of odds, linear in logarithms of the same.
struct Odds {
  double usual, edge, diameter, readable, line_contrast;
};

constexpr PowerLaw kAlong{0.047, 1.0, -0.5, -1.15};
constexpr PowerLaw kAcross{0.040, 1.05, -0.5, -1.0};
constexpr PowerLaw kDiameter{0.073, 0.95, -0.52, -1.0};
constexpr PowerLaw kEquator{3.6e-4, 0.4, -1.0, -2.5};
constexpr PowerLaw kSurface{0.24, 1.0, -0.35, 0.0};
constexpr double kEquatorLineContrastPower = -0.85, kEquatorLineWidthPower = 0.5;
/// What is common over what is each image's own.
constexpr double kCentreCommon = 0.68, kDiameterCommon = 1.03, kEquatorCommon = 0.45;

constexpr Odds kFound{5.1, -1.26, 0.6, 3.5, 0.0};
constexpr Odds kEquatorFound{7.8, -1.3, 2.0, 7.4, 1.9};

struct Logarithms {
  double edge, diameter, readable, line_contrast, line_width;
};

double sd_of(const PowerLaw& law, const Logarithms& of) {
  return law.scale * std::exp(law.edge_power * of.edge + law.diameter_power * of.diameter +
                              law.readable_power * of.readable);
}

double probability_of(const Odds& odds, const Logarithms& of) {
  return 1.0 / (1.0 + std::exp(-(odds.usual + odds.edge * of.edge + odds.diameter * of.diameter +
                                 odds.readable * of.readable + odds.line_contrast * of.line_contrast)));
}

bool is_known(const PictureConditions& c, double readable) {
  return kBallDiameter_px.contains(c.ball_diameter_px) && kBlur_px.contains(c.blur_px) &&
         kMotion_px.contains(c.motion_px) && kExposure.contains(c.exposure) &&
         kFullWell_e.contains(c.full_well_e) && kReadNoise_e.contains(c.read_noise_e) &&
         kLineContrast.contains(c.line_contrast) && kLineWidth.contains(c.line_width) &&
         kReadableShare.contains(readable);
}

}  // namespace

double DigitizerSds::centre_px() const {
  return std::hypot(centre_along_px, centre_across_px) / std::sqrt(2.0);
}

double readable_share(const Overlap& overlap, double exposure) {
  double share = overlap.shares[0];
  for (std::size_t depth = 1; depth < kOverlapDepths; ++depth) {
    const double light = static_cast<double>(depth + 1) * kLightestFelt * kLimb * exposure;
    share += kCovered * std::clamp((1.0 - light) / kFade + 0.5, 0.0, 1.0) * overlap.shares[depth];
  }
  return std::min(1.0, share);
}

std::optional<DigitizerSds> digitizer_sds(const PictureConditions& c) {
  const double readable = readable_share(c.overlap, c.exposure);
  if (!is_known(c, readable)) return std::nullopt;
  const Logarithms of{std::log(std::hypot(c.blur_px, kSharpEdge_px)),
                      std::log(c.ball_diameter_px / kUsualDiameter_px), std::log(readable),
                      std::log(c.line_contrast), std::log(c.line_width / kUsualLineWidth)};
  DigitizerSds sds;
  sds.centre_along_px = sd_of(kAlong, of);
  sds.centre_across_px = sd_of(kAcross, of);
  sds.centre_common_px = kCentreCommon * sds.centre_px();
  sds.diameter_px = sd_of(kDiameter, of);
  sds.diameter_common_px = kDiameterCommon * sds.diameter_px;
  sds.equator_rad = sd_of(kEquator, of) * std::exp(kEquatorLineContrastPower * of.line_contrast +
                                                   kEquatorLineWidthPower * of.line_width);
  sds.equator_common_rad = kEquatorCommon * sds.equator_rad;
  sds.surface_px = sd_of(kSurface, of);
  sds.found = probability_of(kFound, of);
  sds.equator_found = probability_of(kEquatorFound, of);
  return sds;
}

}  // namespace strobe::host
