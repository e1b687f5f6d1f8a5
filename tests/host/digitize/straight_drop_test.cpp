// A ball that falls and rises along one line, told apart by the times of the flashes.
#include "host/digitize/path/straight_drop.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "host/digitize/path/image_order.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::digitize;
using strobe::reduction::Leg;

constexpr double kDiameter_px = 260.0;
constexpr double kPx_per_m = 4000.0;
constexpr double kGravity_pxps2 = 9.81 * kPx_per_m;

/// A ball in view up to 1800 px, touching down at 0.1 s, off again 5 ms later with e = 0.75.
struct Drop {
  double speed_mps = 7.0, period_s = 0.01, first_s = 0.003, error_px = 0.0;

  struct Image {
    double height_px;
    bool rises;
    int flash;
  };

  std::vector<double> flashes() const {
    std::vector<double> times;
    for (double t = first_s; t < 0.25; t += period_s) times.push_back(t);
    return times;
  }

  std::vector<Image> images() const {
    std::vector<Image> images;
    const std::vector<double> times = flashes();
    for (std::size_t k = 0; k < times.size(); ++k) {
      const double before = 0.1 - times[k], after = times[k] - 0.105;
      if (before < 0.0 && after < 0.0) continue;
      const double speed_pxps = kPx_per_m * speed_mps;
      const double height = before > 0.0 ? speed_pxps * before - 0.5 * kGravity_pxps2 * before * before
                                         : 0.75 * speed_pxps * after - 0.5 * kGravity_pxps2 * after * after;
      if (height < 1670.0) images.push_back({0.5 * kDiameter_px + height, after > 0.0, static_cast<int>(k)});
    }
    return images;
  }
};

std::vector<DropImage> seen(const std::vector<Drop::Image>& images, double error_px, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> error(0.0, 1.0);
  std::vector<DropImage> result;
  for (const auto& image : images) result.push_back({image.height_px + error_px * error(random), 0.2});
  return result;
}

PathContext scene(std::span<const double> times) {
  return {kDiameter_px, true, 0.0, times, kGravity_pxps2};
}

}  // namespace

TEST_GROUP(StraightDrops){};

TEST(StraightDrops, AreSplitIntoTheWayDownAndTheWayUp) {
  for (const double period_s : {0.006, 0.01, 0.014}) {
    for (const double first_s : {0.0005, 0.003, 0.0055}) {
      Drop drop;
      drop.period_s = period_s;
      drop.first_s = first_s;
      const auto images = drop.images();
      const auto times = drop.flashes();
      const auto split = split_drop(seen(images, 0.2, 3), scene(times));
      CHECK_TRUE(split.has_value());
      for (const bool rises : {false, true}) {
        const StraightDrop::Flight& flight = rises ? split->up : split->down;
        for (const int i : flight.image) CHECK_EQUAL(rises, images[static_cast<std::size_t>(i)].rises);
        for (std::size_t k = 1; k < flight.image.size(); ++k) {
          const auto flash = [&](std::size_t j) {
            return images[static_cast<std::size_t>(flight.image[j])].flash;
          };
          // An even train leaves open which flashes they are, not how far apart.
          LONGS_EQUAL(flash(k) - flash(k - 1), flight.flash[k] - flight.flash[k - 1]);
        }
      }
      // Two images 0.2 px wrong a step apart: 0.3 px over 40 and more.
      DOUBLES_EQUAL(7.0 * kPx_per_m, split->down.speed_pxps, 0.01 * 7.0 * kPx_per_m);
      DOUBLES_EQUAL(5.25 * kPx_per_m, split->up.speed_pxps, 0.01 * 5.25 * kPx_per_m);
    }
  }
}

TEST(StraightDrops, AreToldWithImagesHidden) {
  const Drop drop;
  const auto times = drop.flashes();
  for (unsigned seed = 1; seed <= 20; ++seed) {
    auto images = drop.images();
    std::mt19937_64 random(seed);
    for (int hidden = 0; hidden < 3; ++hidden)
      images.erase(images.begin() + static_cast<std::ptrdiff_t>(random() % images.size()));
    const auto split = split_drop(seen(images, 0.2, seed), scene(times));
    if (!split) continue;
    // Of other speeds or none, never of wrong ones.
    DOUBLES_EQUAL(7.0 * kPx_per_m, split->down.speed_pxps, 0.01 * 7.0 * kPx_per_m);
    DOUBLES_EQUAL(5.25 * kPx_per_m, split->up.speed_pxps, 0.01 * 5.25 * kPx_per_m);
  }
}

TEST(StraightDrops, OfOneFlightOnlyAreNotTold) {
  // Backwards in time a rise is a fall.
  const Drop drop;
  auto images = drop.images();
  std::erase_if(images, [](const Drop::Image& image) { return !image.rises; });
  const auto times = drop.flashes();
  CHECK_FALSE(split_drop(seen(images, 0.2, 1), scene(times)).has_value());
}

TEST(StraightDrops, OfThreeImagesAreNotTold) {
  Drop drop;
  drop.period_s = 0.05;
  const auto times = drop.flashes();
  CHECK_FALSE(split_drop(seen(drop.images(), 0.0, 1), scene(times)).has_value());
}

TEST(StraightDrops, ThatAreNotToldGiveNoImageALegOrATime) {
  Drop drop;
  drop.period_s = 0.05;
  strobe::reduction::Frame frame;
  frame.surface_px = {{0.0, 0.0}, {1000.0, 0.0}};
  std::vector<Outline> outlines;
  for (const auto& image : drop.images()) {
    Outline outline;
    outline.centre = {500.0, image.height_px};
    outline.diameter = kDiameter_px;
    outline.covariance = 0.04 * cv::Matx33d::eye();
    outline.visible_fraction = 0.9;
    outlines.push_back(outline);
    frame.images.emplace_back();
    frame.images.back().centre_px = {500.0, image.height_px};
  }
  FlightFacts facts;
  facts.flash_times_s = drop.flashes();
  std::vector<std::string> remarks;
  order_images(frame, outlines, facts, remarks);
  for (const auto& image : frame.images) {
    CHECK_TRUE(image.other_leg);
    CHECK_FALSE(image.leg.has_value());
    CHECK_TRUE(std::isnan(image.time_s));
  }
  STRCMP_CONTAINS("flies along one line", remarks.back().c_str());
}
