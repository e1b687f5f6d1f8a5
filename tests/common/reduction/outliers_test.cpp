// How images that do not fit are left out.
#include <random>

#include "common/reduction/outliers.hpp"
#include "common/reduction/shot_fit.hpp"
#include "tests/common/reduction/reduced_frames.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

namespace {

constexpr int kImages = 500;  // a leg

/// A thousand images within 0.1 s, of which this share is anywhere within 300 px of its place.
Frame thousand_images(double wild_share) {
  Setup setup = vacuum();
  setup.incoming = setup.rebound = kImages;
  setup.period_s = 1e-4;
  test::Random random(41);
  Frame frame = test::photograph(Bounce{}, setup, random);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::uniform_real_distribution<double> anywhere(-300.0, 300.0);
  for (BallImage& image : frame.images) {
    if (share(random) >= wild_share) continue;
    image.centre_px.x += anywhere(random);
    image.centre_px.y += anywhere(random);
  }
  return frame;
}

struct Rejected {
  int rounds = 0;
  int left_out = 0;
};

Rejected reject(const Frame& frame) {
  FlagSet flags;
  ShotFit fit =
      fit_shot(*observe(frame, flags), {.effects = flight::kGravityOnly, .reject_outliers = false}, flags);
  Rejected rejected;
  reject_outliers(fit, [&] {
    ++rejected.rounds;
    refit(fit, flight::kGravityOnly);
  });
  for (const Observation& o : fit.observations.images)
    rejected.left_out += o.leg != Leg::contact && !o.use_centre;
  return rejected;
}

}  // namespace

TEST_GROUP(Outliers){};

TEST(Outliers, OfAThousandImagesAreLeftOutManyAtATime) {
  // 32 at once, and fewer where they are unlike: one by one it took a fit of all images for each of 200.
  const Rejected r = reject(thousand_images(0.2));
  CHECK_TRUE(r.left_out > 170 && r.left_out < 230);
  CHECK_TRUE(r.rounds < 40);
  const Readout readout = reduced(thousand_images(0.2));
  CHECK_TRUE(readout.flags.has(Flag::outlier_image));
  equal(15.62, readout.value[Quantity::vx_td_mps], 5.0 * *readout.sd[Quantity::vx_td_mps]);
}

TEST(Outliers, OfAThousandImagesThatAllDisagreeNoneIsThrownAway) {
  const Rejected r = reject(thousand_images(1.0));
  CHECK_EQUAL(0, r.left_out);
  CHECK_TRUE(r.rounds < 40);
  CHECK_TRUE(reduced(thousand_images(1.0)).flags.has(Flag::residuals_exceed_noise));
}

TEST(Outliers, NoMoreThanAQuarterIsLeftOutThoughEachWouldStandOut) {
  Setup setup = vacuum();
  setup.incoming = setup.rebound = 6;
  Frame frame = noisy(setup);
  for (const std::size_t i : {0U, 2U, 5U, 10U}) frame.images[i].diameter_px += 100.0;
  const Readout r = reduced(frame);
  CHECK_FALSE(r.flags.has(Flag::outlier_image));
  CHECK_TRUE(r.flags.has(Flag::residuals_exceed_noise));
}

TEST(Outliers, AnImageThatIsLeftOutLeavesTheShotThatThereIsWithoutIt) {
  // In air, with equal intervals: other spins fit the equators, and friction rules them out.
  const Frame whole = noisy(Setup{});
  Frame with = whole, without = whole;
  with.images[1].centre_px.x += 30.0;
  with.images[1].centre_px.y += 40.0;
  without.images.erase(without.images.begin() + 1);
  const auto left_out = reduce(with, Estimator::best), never_there = reduce(without, Estimator::best);
  CHECK_TRUE(left_out.has_value() && never_there.has_value());
  CHECK_TRUE(left_out->flags.has(Flag::outlier_image));
  CHECK_FALSE(left_out->flags.has(Flag::spin_aliased));
  for (const Quantity q :
       {Quantity::vx_td_mps, Quantity::vy_td_mps, Quantity::vx_lo_mps, Quantity::vy_lo_mps}) {
    const double sd = never_there->sd[q].value();  // either fit ends within a millionth of it
    equal(*never_there->value[q], left_out->value[q], 1e-5 * sd);
    equal(sd, left_out->sd[q], 1e-5 * sd);
  }
}
