#include "host/design/digitizer_noise.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::host {

namespace {

// Fitted to what these measured on 2026-11-27:
//   strobe-bench digitizer-noise --photographs 316 --seed 20261127 --csv FILE
//   strobe-bench digitizer-noise --photographs 72 --each 8 --seed 2 --csv FILE
// with 3,548 airborne images that were measured. By leg, or by photograph for diameters: the variance that an
// image's own error has in the mean that the stated variances weigh. Powers: likeliest for Student's t of 4
// degrees of freedom; scales: rms, where a square counts for no more than ten times what is predicted (one or
// two of a hundred legs are worse). Odds: likeliest.
//
// Held against the next 93 photographs of the second, 12 conditions drawn anew: own errors along, across, of
// diameter and equator were 1.02, 1.07, .96 and .91 of those predicted, images found .85 of all (.88). The
// conditions' ratios scattered by .22, .33, .21 and .43 (rms of their logarithm), of which .19, .22, .18 and
// .23 is how eight photographs' looks differ. Surfaces' scale is known to a factor of two only.

// Light of felt near the limb, over the lightest. Edges fade over kFade before they saturate.
constexpr double kLimb = 0.6;
constexpr double kFade = 0.2;
/// What an edge within other discs tells, over a free one.
constexpr double kCovered = 0.3;
/// More of an outline than this makes measurements no better.
constexpr double kEnough = 0.7;

constexpr double kUsualDiameter_px = 130.0;
constexpr double kUsualLineWidth = 0.04;
/// Steps between images over the diameter that are wide enough for all to be found.
constexpr double kWideStep = 0.7;

/// Half width of an edge without blur: of pixels, and of a usual ball's limb and of its line, which grow with
/// the ball.
constexpr double kSharpEdge_px = 0.6, kLimb_px = 0.3, kLine_px = 1.2;

/// A standard deviation: scale · edge^edge_power · (diameter/usual)^diameter_power ·
/// (readable/enough)^readable_power.
struct PowerLaw {
  double scale, edge_power, diameter_power, readable_power;
};

/// Logarithms of odds, linear in logarithms of the same.
struct Odds {
  double usual, edge, diameter, readable, step, line_contrast;
};

constexpr PowerLaw kAlong{0.0468, 1.23, -0.60, -1.36};
constexpr PowerLaw kAcross{0.0359, 1.43, -0.60, -0.76};
constexpr PowerLaw kDiameter{0.0694, 1.34, -0.65, -1.10};
constexpr PowerLaw kEquator{2.27e-4, 1.57, -1.73, -3.82};
// Of the lines that were taken from one edge, without the 3 % that were off by more than five stated sds.
constexpr PowerLaw kSurface{0.25, 1.2, 0.0, 0.0};
constexpr double kEquatorLineContrastPower = -0.63, kEquatorLineWidthPower = 0.56,
                 kEquatorExposurePower = -0.24;

// What is common, and what is stated, over what is each image's own.
constexpr double kCentreCommon = 0.74, kDiameterCommon = 0.97, kEquatorCommon = 0.75;
// Stated: of centre and diameter as 80 photographs of the second gave it on 2026-11-28, since when sds come
// from residuals alone; there own errors along, across, of diameter and equator were .93, .89, .88 and 1.08.
constexpr double kCentreStated = 1.14, kDiameterStated = 1.00, kEquatorStated = 1.12;

constexpr Odds kFound{6.00, -1.33, 0.32, 1.53, 4.93, 0.0};
constexpr Odds kEquatorFound{4.56, -0.87, 1.94, 7.53, 0.0, 1.45};

struct Logarithms {
  double edge, diameter, readable, step, line_contrast, line_width;
};

double log_edge(const PictureConditions& c, double soft_px) {
  return std::log(std::hypot(c.blur_px, kSharpEdge_px, soft_px * c.ball_diameter_px / kUsualDiameter_px));
}

Logarithms logarithms_of(const PictureConditions& c, double readable) {
  return {.edge = log_edge(c, kLimb_px),
          .diameter = std::log(c.ball_diameter_px / kUsualDiameter_px),
          .readable = std::log(readable / kEnough),
          .step = std::log(std::min(1.0, c.step / kWideStep)),
          .line_contrast = std::log(c.line_contrast),
          .line_width = std::log(c.line_width / kUsualLineWidth)};
}

double sd_of(const PowerLaw& law, const Logarithms& of) {
  return law.scale * std::exp(law.edge_power * of.edge + law.diameter_power * of.diameter +
                              law.readable_power * std::min(0.0, of.readable));
}

double equator_sd_rad(const PictureConditions& c, Logarithms of) {
  of.edge = log_edge(c, kLine_px);
  return sd_of(kEquator, of) * std::pow(c.exposure, kEquatorExposurePower) *
         std::exp(kEquatorLineContrastPower * of.line_contrast + kEquatorLineWidthPower * of.line_width);
}

double probability_of(const Odds& odds, const Logarithms& of) {
  return 1.0 / (1.0 + std::exp(-(odds.usual + odds.edge * of.edge + odds.diameter * of.diameter +
                                 odds.readable * of.readable + odds.step * of.step +
                                 odds.line_contrast * of.line_contrast)));
}

bool is_known(const PictureConditions& c, double readable) {
  return kBallDiameter_px.contains(c.ball_diameter_px) && kBlur_px.contains(c.blur_px) &&
         kMotion_px.contains(c.motion_px) && kExposure.contains(c.exposure) &&
         kFullWell_e.contains(c.full_well_e) && kReadNoise_e.contains(c.read_noise_e) &&
         kLineContrast.contains(c.line_contrast) && kLineWidth.contains(c.line_width) &&
         kReadableShare.contains(readable) && c.step >= kMinStep;
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
  const Logarithms of = logarithms_of(c, readable);
  DigitizerSds sds;
  sds.centre_along_px = sd_of(kAlong, of);
  sds.centre_across_px = sd_of(kAcross, of);
  sds.centre_common_px = kCentreCommon * sds.centre_px();
  sds.centre_stated_px = kCentreStated * sds.centre_px();
  sds.diameter_px = sd_of(kDiameter, of);
  sds.diameter_common_px = kDiameterCommon * sds.diameter_px;
  sds.diameter_stated_px = kDiameterStated * sds.diameter_px;
  sds.equator_rad = equator_sd_rad(c, of);
  sds.equator_common_rad = kEquatorCommon * sds.equator_rad;
  sds.equator_stated_rad = kEquatorStated * sds.equator_rad;
  sds.surface_px = sd_of(kSurface, of);
  sds.found = probability_of(kFound, of);
  sds.equator_found = probability_of(kEquatorFound, of);
  return sds;
}

}  // namespace strobe::host
