#include <cmath>
#include <random>
#include <vector>

#include "host/digitize/outline/edge_profile.hpp"
#include "host/digitize/outline/outline_fit.hpp"
#include "host/digitize/outline/sector_offsets.hpp"

#include <CppUTest/TestHarness.h>

using strobe::digitize::fit_oval_model;
using strobe::digitize::OvalSample;

TEST_GROUP(OvalAgreement) {
  const cv::Point2d middle{1000.0, 600.0};
  const double reach_px = 1200.0;
  const double corner_sd = 0.06;

  /// What perspective makes of round balls: `share` of the radius at the corners, away from the middle.
  cv::Vec2d stretched(cv::Point2d at, double share) const {
    const cv::Point2d d = (at - middle) * (1.0 / reach_px);
    return share * cv::Vec2d(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y);
  }

  std::vector<OvalSample> samples(double share, double sd, std::size_t count) const {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal(0.0, sd);
    std::vector<OvalSample> all;
    for (std::size_t i = 0; i < count; ++i) {
      const cv::Point2d at(90.0 * static_cast<double>(i), 100.0 + 37.0 * static_cast<double>((7 * i) % 29));
      all.push_back({at, stretched(at, share) + cv::Vec2d(normal(random), normal(random)),
                     cv::Matx22d::eye() * (sd * sd)});
    }
    return all;
  }
};

TEST(OvalAgreement, FindsThePerspectiveThatStretchesAllImages) {
  const auto agreed = fit_oval_model(samples(0.02, 1e-3, 20), middle, reach_px, corner_sd);
  CHECK_TRUE(agreed.has_value());
  const cv::Point2d corner = middle + cv::Point2d(reach_px, 0.0);
  // 40 numbers of sd 1e-3, of which those far out tell most: some 4e-4 at the corner. Four of them.
  DOUBLES_EQUAL(0.02, agreed->at(corner)[0], 1.6e-3);
  DOUBLES_EQUAL(0.0, agreed->at(corner)[1], 1.6e-3);
  CHECK(agreed->scatter() < 1.5e-3);
}

TEST(OvalAgreement, IsNotTakenInByOneImageThatIsOtherwise) {
  auto all = samples(0.0, 1e-3, 20);
  all[4].oval = {0.05, -0.05};
  const auto agreed = fit_oval_model(all, middle, reach_px, corner_sd);
  CHECK_TRUE(agreed.has_value());
  CHECK(cv::norm(agreed->at(all[4].at)) < 2e-3);
}

TEST(OvalAgreement, SaysSoWhereImagesDisagree) {
  auto all = samples(0.0, 4e-3, 20);
  for (OvalSample& sample : all) sample.covariance = cv::Matx22d::eye() * 1e-8;
  const auto agreed = fit_oval_model(all, middle, reach_px, corner_sd);
  CHECK_TRUE(agreed.has_value());
  // The spread itself: of 40 numbers to a ninth; three of those, and what the fit took up.
  DOUBLES_EQUAL(4e-3, agreed->scatter(), 1.6e-3);
}

TEST(OvalAgreement, KnowsLessOfCornersWhereNoImageIs) {
  std::vector<OvalSample> near;
  for (int i = 0; i < 6; ++i) {
    const cv::Point2d at = middle + cv::Point2d(60.0 * i - 150.0, 0.0);
    near.push_back({at, stretched(at, 0.04), cv::Matx22d::eye() * 1e-6});
  }
  const auto agreed = fit_oval_model(near, middle, reach_px, corner_sd);
  CHECK_TRUE(agreed.has_value());
  const cv::Point2d corner = middle + cv::Point2d(0.0, reach_px);
  // Up to an eighth of the way to the corner an ovality of 4 % there is 6e-4: less than one image's sd of 1e-3. So of
  // the corner nearly the prior is all that is known.
  CHECK(std::sqrt(agreed->covariance(corner)(0, 0)) > 0.5 * corner_sd);
  CHECK(std::sqrt(agreed->covariance(middle)(0, 0)) < 2e-3);
}

TEST(OvalAgreement, WithoutAnImageIsWhatTheOthersShow) {
  auto all = samples(0.02, 1e-5, 12);
  for (OvalSample& sample : all) sample.covariance = cv::Matx22d::eye() * 1e-6;
  const auto agreed = fit_oval_model(all, middle, reach_px, corner_sd);
  const OvalSample left = all.back();
  all.pop_back();
  const auto others = fit_oval_model(all, middle, reach_px, corner_sd);
  CHECK_TRUE(agreed.has_value() && others.has_value());
  // All agree to a hundredth of their sds, so that no weight differs by more than its square.
  const auto without = agreed->without(left);
  DOUBLES_EQUAL(others->at(left.at)[0], without.at(left.at)[0], 1e-6);
  DOUBLES_EQUAL(1.0, without.covariance(left.at)(0, 0) / others->covariance(left.at)(0, 0), 1e-3);
  CHECK(agreed->covariance(left.at)(0, 0) < 0.99 * without.covariance(left.at)(0, 0));
}

TEST(OvalAgreement, NeedsSomeImages) {
  CHECK_FALSE(fit_oval_model(samples(0.0, 1e-3, 4), middle, reach_px, corner_sd));
}

// Which sectors of an outline share the terminator's error.
namespace {

using namespace strobe::digitize;

constexpr int kSectors = 80;
constexpr double kSigma_px = 1.2;

/// Dark over `dark` sectors; from both ends of them on the limb's step grows by a tenth a sector, up to 1, and what
/// its curvature adds is a quarter of a full step.
SectorOffsets outline(int dark) {
  SectorOffsets offsets;
  offsets.edges.resize(kSectors);
  for (int i = 0; i < kSectors; ++i) {
    SectorEdge& edge = offsets.edges[static_cast<std::size_t>(i)];
    edge.no_edge = i < dark;
    edge.usable = !edge.no_edge;
    edge.sd_px = 0.05;
    const int from_end = std::min(i - dark + 1, kSectors - i);
    edge.step = edge.no_edge ? 0.0 : std::min(1.0, 0.1 * from_end);
    edge.rounding = edge.no_edge ? 0.0 : 0.25 * (1.0 - edge.step) + 0.02;
  }
  downweight_shadow(offsets, kSigma_px);
  return offsets;
}

double common(const SectorOffsets& offsets, int sector) {
  return offsets.common_sd[static_cast<std::size_t>(sector)];
}

}  // namespace

TEST_GROUP(SectorOffsets){};

TEST(SectorOffsets, OfAHalfLitBallShareAnErrorAsFarAsLightIsOblique) {
  const SectorOffsets offsets = outline(40);
  CHECK_TRUE(offsets.half_lit);
  // Next to the terminator the curvature adds more than the step.
  CHECK_COMPARE(common(offsets, 40), >, 0.3 * kSigma_px);
  // Beyond the reach of single edges, with a step twice the rounding's.
  CHECK_COMPARE(common(offsets, 45), >, kSigma_px / 8.0);
  DOUBLES_EQUAL(common(offsets, 45), common(offsets, 80 - 6), 1e-12);
  // Where the step is eight times the rounding it is as clear as anywhere.
  DOUBLES_EQUAL(0.0, common(offsets, 60), 0.0);
  for (int i = 41; i < 60; ++i) CHECK_COMPARE(common(offsets, i), <=, common(offsets, i - 1) + 1e-12);
}

TEST(SectorOffsets, OfAShortShadowShareAnErrorBesideItOnly) {
  const SectorOffsets offsets = outline(8);
  CHECK_FALSE(offsets.half_lit);
  CHECK_COMPARE(common(offsets, 8), >, 0.0);
  DOUBLES_EQUAL(0.0, common(offsets, 8 + 6), 0.0);
  DOUBLES_EQUAL(0.0, common(offsets, 44), 0.0);
}

TEST(SectorOffsets, CountTheSharedErrorAsVarianceOfEach) {
  SectorOffsets offsets = outline(40);
  offsets.weight.resize(kSectors);
  offsets.robust = offsets.sensitivity = offsets.weight;
  const std::vector<double> residuals(kSectors, 0.0);
  reweight(offsets, residuals);
  const double at_terminator = offsets.weight[40], clear = offsets.weight[60];
  const double expected = (0.05 * 0.05 + std::pow(common(offsets, 40), 2)) / (0.05 * 0.05);
  // The variance that residuals show is at its least, 1e-6 px².
  DOUBLES_EQUAL(expected, clear / at_terminator, 1e-3 * expected);
  DOUBLES_EQUAL(0.0, offsets.weight[20], 0.0);
}

using strobe::digitize::blurred_sqrt;
using strobe::digitize::blurred_step;

TEST_GROUP(EdgeProfile){};

TEST(EdgeProfile, OfAStepIsHalfAtTheOutline) {
  // Linear interpolation between cells of 1/64 errs by at most (1/64)²/8 of the second derivative, 0.25.
  DOUBLES_EQUAL(0.5, blurred_step(0.0, 1.7).value, 1e-5);
  DOUBLES_EQUAL(0.841344746, blurred_step(1.7, 1.7).value, 1e-5);
  DOUBLES_EQUAL(1.0, blurred_step(40.0, 1.7).value, 1e-9);
}

TEST(EdgeProfile, OfARootIsTheGammaFunctionsAtTheOutlineAndTheRootFarInside) {
  // ∫ sqrt(t) exp(-t²/2) dt / sqrt(2 pi) = 2^(-1/4) Gamma(3/4) / sqrt(2 pi)
  const double at_zero = std::pow(2.0, -0.25) * std::tgamma(0.75) / std::sqrt(2.0 * std::acos(-1.0));
  DOUBLES_EQUAL(at_zero, blurred_sqrt(0.0, 1.0).value, 1e-4);
  DOUBLES_EQUAL(2.0 * at_zero, blurred_sqrt(0.0, 4.0).value, 2e-4);
  DOUBLES_EQUAL(5.0, blurred_sqrt(25.0, 0.5).value, 1e-3);
}

TEST(EdgeProfile, ChangesAsItsDerivativesSay) {
  constexpr double kSmall = 0.25;
  for (const double depth : {-2.0, -0.5, 0.3, 1.0, 4.0, 30.0}) {
    for (const auto profile : {blurred_step, blurred_sqrt}) {
      const double sigma = 1.3;
      const auto here = profile(depth, sigma);
      // Central differences; third derivatives are below 0.6 here, which leaves 0.6·kSmall²/6.
      DOUBLES_EQUAL(
          (profile(depth + kSmall, sigma).value - profile(depth - kSmall, sigma).value) / (2 * kSmall),
          here.by_depth, 0.007);
      DOUBLES_EQUAL(
          (profile(depth, sigma + kSmall).value - profile(depth, sigma - kSmall).value) / (2 * kSmall),
          here.by_sigma, 0.02);
    }
  }
}
