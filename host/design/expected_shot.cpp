#include "host/design/expected_shot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/geometry/line.hpp"
#include "common/shot/plan_check.hpp"
#include "common/units/angles.hpp"
#include "host/assembly/camera_map.hpp"
#include "host/config/digitize_times.hpp"
#include "host/design/digitizer_noise.hpp"

namespace strobe::host {
namespace {

using reduction::BallImage;
using reduction::PointPx;

// Of a diameter, by the distance from the centre to a point of the edge, both by hand.
const double kHandDiameterRatio = 2.0 * std::sqrt(2.0);
// An image that is less probably found than not is not counted on.
constexpr double kLikely = 0.5;

/// An image on the photograph, before it is measured.
struct Projected {
  double time_s = 0.0;  ///< on the train's axis
  BallCourse::Place place;
  PointPx centre_px;
};

class View {
 public:
  View(const SetUp& set_up, double spot_m, double diameter_m)
      : set_up_(set_up),
        spot_m_(spot_m),
        radius_px_(0.5 * diameter_m * set_up.px_per_m),
        axes_(set_up.surface_angle_rad) {}

  PointPx project(const Eigen::Vector2d& from_touchdown_m) const {
    const Eigen::Vector2d p = set_up_.px_per_m * (axes_ * (from_touchdown_m + Eigen::Vector2d(spot_m_, 0.0)));
    return {set_up_.touchdown_x_px + p.x(), set_up_.surface_y_px + p.y()};
  }
  bool shows(const PointPx& centre) const {
    return centre.x >= radius_px_ && centre.x <= set_up_.width_px - radius_px_ && centre.y >= radius_px_ &&
           centre.y <= set_up_.height_px - radius_px_;
  }
  double diameter_px() const { return 2.0 * radius_px_; }
  /// Points of the surface's line, over most of the photograph.
  std::vector<PointPx> surface() const {
    const double half_m = 0.45 * set_up_.width_px / set_up_.px_per_m;
    std::vector<PointPx> points;
    for (int i = 0; i < kSurfacePoints; ++i)
      points.push_back(project({(2.0 * i / (kSurfacePoints - 1) - 1.0) * half_m - spot_m_, 0.0}));
    return points;
  }

 private:
  const SetUp& set_up_;
  double spot_m_, radius_px_;
  geometry::Rotation2d axes_;
};

std::vector<Projected> projected(const BallCourse& course, const BallDraw& draw, const ExpectedTrain& train,
                                 const View& view) {
  const double touchdown_s = train.touchdown_s + draw.arrival * train.arrival_sd_s;
  std::vector<Projected> images;
  for (const double flash_s : train.flash_s) {
    const BallCourse::Place place = course.at(flash_s - touchdown_s);
    if (place.beyond) continue;
    const PointPx centre = view.project(place.centre_m);
    if (view.shows(centre)) images.push_back({flash_s, place, centre});
  }
  return images;
}

void state_calibration(const SetUp& set_up, const ExpectedBall& ball, reduction::Frame& frame) {
  frame.ball_diameter_m = ball.ball.diameter_m;
  frame.ball_diameter_sd_m = set_up.ball_diameter_sd_m;
  frame.ball_mass_kg = ball.ball.mass_kg;
  frame.ball_alpha = ball.ball.alpha;
  frame.air_density_kgpm3 = ball.air_density_kgpm3;
  if (ball.kind) frame.air_law = ball.kind->air;
  frame.temperature_c = set_up.temperature_c;
  frame.fastest_spin_radps = set_up.fastest_spin_radps;
  frame.surface_angle_deg = degrees(set_up.surface_angle_rad);
  if (!set_up.camera.px_per_m_sd) return;  // a first guess, which each photograph's diameters refine
  frame.px_per_m = set_up.px_per_m;
  frame.px_per_m_sd = set_up.camera.px_per_m_sd;
}

/// What will be stated of an image, and how likely it is that it will be measured.
struct Stated {
  double centre_px = 0.0, diameter_px = 0.0, equator_rad = 0.0, surface_px = 0.0;
  double found = 1.0, equator_found = 1.0;
};

Stated by_hand(const SetUp& set_up) {
  const double sd_px = set_up.hand_centre_sd_m * set_up.px_per_m;
  return {sd_px, kHandDiameterRatio * sd_px, set_up.hand_equator_sd_rad, sd_px};
}

/// Absent: the digitizer's noise is not known there.
std::optional<Stated> by_digitizer(const Projected& image, const Overlap& overlap, double diameter_px,
                                   const SetUp& set_up) {
  if (readable_share(overlap, set_up.picture.exposure) < kReadableShare.least) return Stated{.found = 0.0};
  const auto sds =
      digitizer_sds({.ball_diameter_px = diameter_px,
                     .blur_px = set_up.picture.blur_px,
                     .motion_px = image.place.speed_mps * set_up.picture.flash_s * set_up.px_per_m,
                     .exposure = set_up.picture.exposure,
                     .overlap = overlap});
  if (!sds) return std::nullopt;
  return Stated{
      sds->centre_stated_px, sds->diameter_stated_px, sds->equator_stated_rad, sds->surface_px, sds->found,
      sds->equator_found};
}

/// What the digitizer states that all diameters are off alike, of the sds that it states of each: .5 to .7 on
/// photographs of either renderer.
constexpr double kSharedOfDiameterSd = 0.6;

std::optional<double> shared_diameter_sd_px(const reduction::Frame& frame) {
  if (frame.images.empty()) return std::nullopt;
  double sum_px = 0.0;
  for (const BallImage& image : frame.images) sum_px += *image.diameter_sd_px;
  return kSharedOfDiameterSd * sum_px / static_cast<double>(frame.images.size());
}

/// Images that lie on the same place of its outline, itself included.
int depth_of(const Overlap& overlap) {
  const auto deepest = std::ranges::find_if(overlap.shares.rbegin(), overlap.shares.rend(),
                                            [](double share) { return share > 0.0; });
  return static_cast<int>(overlap.shares.rend() - deepest);
}

BallImage measured(const Projected& seen, const Stated& stated, double diameter_px) {
  BallImage image;
  image.time_s = seen.time_s;
  image.centre_px = seen.centre_px;
  image.diameter_px = diameter_px;
  const double variance = stated.centre_px * stated.centre_px;
  image.centre_cov_px2 = {variance, 0.0, 0.0, variance};
  image.diameter_sd_px = stated.diameter_px;
  image.equator_sd_rad = stated.equator_rad;
  return image;
}

}  // namespace

ExpectedTrain expected_train(const ShotPlan& plan, const SetUp& set_up, const ExpectedBall& ball) {
  ExpectedTrain train;
  if (plan.code.empty()) {
    for (int i = 0; i < flash_count(plan); ++i) train.flash_s.push_back(i * to_seconds(plan.period));
  } else {
    train.flash_s = plan_flashes(plan);
  }
  if (plan.train == Train::gated) {
    train.touchdown_s = set_up.gate_distance_m / ball.speed_mps.mean - to_seconds(plan.gate_delay);
    train.arrival_sd_s = std::hypot(set_up.gate_distance_sd_m,
                                    set_up.gate_distance_m * ball.speed_mps.sd / ball.speed_mps.mean) /
                         ball.speed_mps.mean;
  } else {
    const Duration stated = plan.impact_at > Duration{} ? plan.impact_at : set_up.limits.impact_at;
    train.touchdown_s = to_seconds(stated > Duration{} ? stated : plan.exposure / 2);
    train.arrival_sd_s = set_up.arrival_sd_s;
  }
  return train;
}

ExpectedShot expected_shot(const BallCourse& course, const BallDraw& draw, const ExpectedTrain& train,
                           const ExpectedBall& ball, const SetUp& set_up) {
  const View view(set_up, draw.spot * set_up.spot_sd_m, ball.ball.diameter_m);
  const std::vector<Projected> images = projected(course, draw, train, view);
  std::vector<PointPx> centres;
  for (const Projected& image : images) centres.push_back(image.centre_px);
  const std::vector<Overlap> overlap = overlaps(centres, view.diameter_px());
  const double touchdown_s = train.touchdown_s + draw.arrival * train.arrival_sd_s;

  ExpectedShot shot;
  for (const Overlap& o : overlap) shot.most_at_one_place = std::max(shot.most_at_one_place, depth_of(o));
  state_calibration(set_up, ball, shot.frame);
  shot.frame.surface_px = view.surface();
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].place.in_contact) continue;
    const std::optional<Stated> stated =
        set_up.measured_by == MeasuredBy::hand
            ? std::optional(by_hand(set_up))
            : by_digitizer(images[i], overlap[i], view.diameter_px(), set_up);
    if (!stated) {
      shot.not_known = fmt::format(
          "the digitizer's noise is not known for balls of {:.0f} px, blur of {:.1f} px and exposure {:g}",
          view.diameter_px(), set_up.picture.blur_px, set_up.picture.exposure);
      continue;
    }
    if (stated->found < kLikely) continue;
    shot.frame.surface_sd_px = stated->surface_px;
    shot.largest_overlap = std::max(shot.largest_overlap, overlap[i].share());
    const bool incoming = images[i].time_s < touchdown_s;
    (incoming ? shot.incoming : shot.rebound)++;
    BallImage image = measured(images[i], *stated, view.diameter_px());
    image.leg = incoming ? Leg::incoming : Leg::rebound;
    if (stated->equator_found >= kLikely)
      image.equator_rad =
          wrap_half_turn(draw.equator_rad + images[i].place.equator_rad + set_up.surface_angle_rad);
    image.time_sd_s = set_up.flash_time_sd_s;
    shot.frame.images.push_back(std::move(image));
  }
  for (std::size_t i = shot.frame.images.size(); i-- > 0;)
    shot.frame.images[i].time_s -= shot.frame.images.front().time_s;
  if (set_up.measured_by != MeasuredBy::hand)
    shot.frame.shared_diameter_sd_px = shared_diameter_sd_px(shot.frame);
  set_calibration(set_up.camera, shot.frame);
  return shot;
}

reduction::Frame with_noise(reduction::Frame frame, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const auto move = [&](PointPx& p, double sd_px) {
    p.x += sd_px * normal(engine);
    p.y += sd_px * normal(engine);
  };
  for (PointPx& p : frame.surface_px) move(p, frame.surface_sd_px.value_or(0.0));
  const double shared_sd_px = frame.shared_diameter_sd_px.value_or(0.0),
               shared_px = shared_sd_px * normal(engine);
  for (BallImage& image : frame.images) {
    move(image.centre_px, std::sqrt((*image.centre_cov_px2)[0]));
    const double own_variance = std::pow(*image.diameter_sd_px, 2) - shared_sd_px * shared_sd_px;
    image.diameter_px += shared_px + std::sqrt(std::max(0.0, own_variance)) * normal(engine);
    if (image.equator_rad) *image.equator_rad += *image.equator_sd_rad * normal(engine);
  }
  return frame;
}

}  // namespace strobe::host
