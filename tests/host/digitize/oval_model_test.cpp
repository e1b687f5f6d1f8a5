#include "host/digitize/outline/oval_model.hpp"

#include <random>
#include <vector>

#include <CppUTest/TestHarness.h>

using strobe::digitize::fit_oval_model;
using strobe::digitize::OvalSample;

TEST_GROUP(OvalAgreement) {
  const cv::Point2d middle{1000.0, 600.0};
  const double reach_px = 1200.0;

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
  const auto agreed = fit_oval_model(samples(0.02, 1e-3, 20), middle, reach_px);
  CHECK_TRUE(agreed.has_value());
  const cv::Point2d corner = middle + cv::Point2d(reach_px, 0.0);
  // 40 numbers of sd 1e-3, of which those far out tell most: some 4e-4 at the corner. Four of them.
  DOUBLES_EQUAL(0.02, agreed->at(corner)[0], 1.6e-3);
  DOUBLES_EQUAL(0.0, agreed->at(corner)[1], 1.6e-3);
  CHECK(agreed->sd() < 1.5e-3);
}

TEST(OvalAgreement, IsNotTakenInByOneImageThatIsOtherwise) {
  auto all = samples(0.0, 1e-3, 20);
  all[4].oval = {0.05, -0.05};
  const auto agreed = fit_oval_model(all, middle, reach_px);
  CHECK_TRUE(agreed.has_value());
  CHECK(cv::norm(agreed->at(all[4].at)) < 2e-3);
}

TEST(OvalAgreement, SaysSoWhereImagesDisagree) {
  auto all = samples(0.0, 4e-3, 20);
  for (OvalSample& sample : all) sample.covariance = cv::Matx22d::eye() * 1e-8;
  const auto agreed = fit_oval_model(all, middle, reach_px);
  CHECK_TRUE(agreed.has_value());
  // The spread itself: of 40 numbers to a ninth; three of those, and what the fit took up.
  DOUBLES_EQUAL(4e-3, agreed->sd(), 1.6e-3);
}

TEST(OvalAgreement, NeedsSomeImages) { CHECK_FALSE(fit_oval_model(samples(0.0, 1e-3, 4), middle, reach_px)); }
