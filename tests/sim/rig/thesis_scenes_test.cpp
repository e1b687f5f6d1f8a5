// The 21 scenes against the tables that they stand for.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "sim/fit/fit.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/rig/tablet.hpp"
#include "sim/rig/truth.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;
using reduction::Quantity;

const std::vector<thesis::Condition>& conditions() {
  static const std::vector<thesis::Condition> all = [] {
    auto data = thesis::load(STROBE_THESIS_FOLDER, thesis::Version::corrected);
    if (!data) FAIL(data.error().message.c_str());
    return data->conditions;
  }();
  return all;
}

std::string scene_text(const thesis::Condition& condition) {
  std::ifstream file(std::string(STROBE_SCENES_FOLDER) + "/" + condition.name() + ".toml");
  CHECK_TEXT(file.good(), condition.name().c_str());
  return {std::istreambuf_iterator<char>(file), {}};
}

Scene scene_of(const thesis::Condition& condition) {
  auto scene = parse_scene(scene_text(condition), condition.name() + ".toml");
  if (!scene) FAIL(scene.error().message.c_str());
  return *scene;
}

/// Straight two-point values of one digitized shot, written down independently of the reduction.
struct TwoPoint {
  double vx = 0.0, vy = 0.0, v = 0.0, angle_deg = 0.0, spin = 0.0;
};

struct Measured {
  TwoPoint in, out;
};

struct Level {
  double px_per_m, cosine, sine;
};

Level level_of(const reduction::Frame& frame, double diameter_m) {
  double mean_x = 0.0, mean_y = 0.0, sxx = 0.0, sxy = 0.0, diameter = 0.0;
  for (const auto& p : frame.surface_px) {
    mean_x += p.x / 4.0;
    mean_y += p.y / 4.0;
  }
  for (const auto& p : frame.surface_px) {
    sxx += (p.x - mean_x) * (p.x - mean_x);
    sxy += (p.x - mean_x) * (p.y - mean_y);
  }
  for (const auto& image : frame.images)
    diameter += image.diameter_px / static_cast<double>(frame.images.size());
  const double tilt = std::atan2(sxy, sxx);
  return {diameter / diameter_m, std::cos(tilt), std::sin(tilt)};
}

TwoPoint between(const reduction::BallImage& a, const reduction::BallImage& b, const Level& level) {
  constexpr double period_s = 0.003;
  const double dx = (b.centre_px.x - a.centre_px.x) / level.px_per_m;
  const double dy = (b.centre_px.y - a.centre_px.y) / level.px_per_m;
  TwoPoint t;
  t.vx = (level.cosine * dx + level.sine * dy) / period_s;
  t.vy = (level.cosine * dy - level.sine * dx) / period_s;
  t.v = std::hypot(t.vx, t.vy);
  t.angle_deg = std::atan2(t.vy, t.vx) * 180.0 / std::numbers::pi;
  t.spin = std::remainder(*b.equator_rad - *a.equator_rad, std::numbers::pi) / period_s;
  return t;
}

bool measure(const reduction::Frame& frame, double diameter_m, Measured& measured) {
  const reduction::BallImage* in[2] = {nullptr, nullptr};
  const reduction::BallImage* out[2] = {nullptr, nullptr};
  for (const auto& image : frame.images) {
    if (image.leg == reduction::Leg::incoming) {
      in[0] = in[1];
      in[1] = &image;
    } else if (image.leg == reduction::Leg::rebound) {
      if (!out[0])
        out[0] = &image;
      else if (!out[1])
        out[1] = &image;
    }
  }
  if (!in[0] || !out[1]) return false;
  const Level level = level_of(frame, diameter_m);
  measured.in = between(*in[0], *in[1], level);
  measured.out = between(*out[0], *out[1], level);
  return true;
}

class Moments {
 public:
  void add(double x) {
    ++n_;
    const double d = x - mean_;
    mean_ += d / n_;
    m2_ += d * (x - mean_);
  }
  double mean() const { return mean_; }
  double sd() const { return std::sqrt(m2_ / n_); }

 private:
  double n_ = 0.0, mean_ = 0.0, m2_ = 0.0;
};

struct Spread {
  Moments vx, vy, v, angle, spin;
  void add(const TwoPoint& t) {
    vx.add(t.vx);
    vy.add(t.vy);
    v.add(t.v);
    angle.add(t.angle_deg);
    spin.add(t.spin);
  }
};

constexpr std::uint64_t kThesisSeed = 2024;
constexpr int kShots = 1000;

struct Series {
  Spread in, out;
};

/// Shot once, for all tests.
const Series& series_of(const thesis::Condition& condition) {
  static std::map<std::string, Series> all;
  const auto [place, is_new] = all.try_emplace(condition.name());
  if (!is_new) return place->second;
  const Scene scene = scene_of(condition);
  test::VirtualRigFixture fixture(scene, kThesisSeed);
  for (int i = 0; i < kShots; ++i) {
    const Exposure exposure =
        fixture.shoot({.exposure = milliseconds(100), .impact_after = milliseconds(50)});
    Measured measured;
    CHECK(measure(digitize(scene, kThesisSeed, exposure).frame, scene.ball.diameter_m, measured));
    place->second.in.add(measured.in);
    place->second.out.add(measured.out);
  }
  return place->second;
}

/// The published sd, reached within the sampling error of our own (four standard errors, sd/sqrt(2n)), the
/// table's rounding, and 3 % for the noise of the scale and what is not of first order.
void check_sd(const std::string& what, const thesis::MeanSd& published, const Moments& simulated,
              double rounding) {
  const double tolerance = published.sd * (4.0 / std::sqrt(2.0 * kShots) + 0.03) + rounding;
  CHECK_TEXT(std::abs(published.sd - simulated.sd()) <= tolerance,
             fmt::format("{}: published sd {}, simulated {:.3f} (seed {})", what, published.sd,
                         simulated.sd(), kThesisSeed)
                 .c_str());
}

/// Where the fit says that the published sd is missed, ours is what it says; or nearer to the published one,
/// since it reckons to first order and balls about to grip are not of first order.
void check_sd_or_miss(const std::string& what, const FittedScene& fitted, Quantity quantity,
                      thesis::MeanSd published, const Moments& simulated, double rounding) {
  for (const MissedSpread& miss : fitted.missed) {
    if (miss.quantity != quantity) continue;
    const auto [least, most] = std::minmax(published.sd, miss.expected_sd);
    published.sd = std::clamp(simulated.sd(), least, most);
  }
  check_sd(what, published, simulated, rounding);
}

/// Whether a published sd, the population form of a sample of n, is a credible one of a population with the
/// simulated sd: n·s²/sigma² is chi-squared with n - 1 degrees of freedom; two-sided 1e-4 by Wilson and
/// Hilferty.
bool credible(double published_sd, double simulated_sd, int n) {
  const double k = n - 1.0;
  const double ratio = n * published_sd * published_sd / (simulated_sd * simulated_sd) / k;
  const double z = (std::cbrt(ratio) - (1.0 - 2.0 / (9.0 * k))) / std::sqrt(2.0 / (9.0 * k));
  return std::abs(z) < 3.9;
}

const FittedScene& fitted_of(const thesis::Condition& condition) {
  static std::map<std::string, FittedScene> all;
  const auto known = all.find(condition.name());
  if (known != all.end()) return known->second;
  auto fitted = fit_scene(condition);
  if (!fitted) FAIL(fitted.error().message.c_str());
  return all.emplace(condition.name(), *std::move(fitted)).first->second;
}

reduction::Quantities exact_truth(Scene scene) {
  test::make_exact(scene);
  const auto path = BallPath::make(scene, draw_shot_conditions(scene, 1, 1));
  CHECK(path.has_value());
  return true_readout(scene, *path);
}

}  // namespace

TEST_GROUP(ThesisScenes){};

TEST(ThesisScenes, AreTwentyOne) { LONGS_EQUAL(21, conditions().size()); }

TEST(ThesisScenes, FilesAreWhatTheFitDerivesFromTheTables) {
  for (const auto& condition : conditions())
    CHECK_EQUAL(to_toml(fitted_of(condition), condition), scene_text(condition));
}

TEST(ThesisScenes, WithoutSpreadReboundAsTheTablesMeans) {
  // Velocities and spins: the scene files' eight digits, through an integration to 1e-9; the fit says what
  // the mechanics leave of vx and spin. Angles: the printed components' rounding (.005 m/s each) and their
  // own, and that a mean of angles is not the angle of the means (half the square of the angles' sd, and the
  // product of the components' relative sds). Ratios: rounding and likewise the product of relative sds.
  for (const auto& c : conditions()) {
    const auto q = exact_truth(scene_of(c));
    const FittedScene& fitted = fitted_of(c);
    const auto near = [&](Quantity quantity, double expected, double tolerance) {
      CHECK_TEXT(
          std::abs(*q[quantity] - expected) <= tolerance,
          fmt::format("{} {}: {} for {} ± {}", c.name(), name(quantity), *q[quantity], expected, tolerance)
              .c_str());
    };
    near(Quantity::vx_td_mps, c.vx_td_mps.mean, 1e-6);
    near(Quantity::vy_td_mps, c.vy_td_mps.mean, 1e-6);
    near(Quantity::omega_td_radps, c.omega_td_radps.mean, 1e-6);
    near(Quantity::vx_lo_mps, c.vx_lo_mps.mean + fitted.left_vx_mps, 1e-6);
    near(Quantity::vy_lo_mps, c.vy_lo_mps.mean, 1e-6);
    near(Quantity::omega_lo_radps, c.omega_lo_radps.mean + fitted.left_omega_radps, 1e-4);
    near(Quantity::dwell_time_ms, c.dwell_time_ms.mean, 1e-6);
    const auto angle_tolerance = [](const thesis::MeanSd& vx, const thesis::MeanSd& vy) {
      const double v = std::hypot(vx.mean, vy.mean), degrees = 180.0 / std::numbers::pi;
      return degrees * (0.00707 / v + (vx.sd * vx.sd + vy.sd * vy.sd) / (2.0 * v * v)) + 0.005;
    };
    near(Quantity::theta_in_deg, c.theta_in_deg.mean, angle_tolerance(c.vx_td_mps, c.vy_td_mps));
    const double left = std::abs(fitted.left_vx_mps);
    near(Quantity::theta_out_deg, c.theta_out_deg.mean,
         angle_tolerance(c.vx_lo_mps, c.vy_lo_mps) + left / c.v_lo_mps.mean * 180.0 / std::numbers::pi);
    const double spread = std::abs(c.vy_td_mps.sd / c.vy_td_mps.mean) * (c.e.sd / c.e.mean + 1.0) *
                          std::abs(c.vy_td_mps.sd / c.vy_td_mps.mean);
    near(Quantity::e, c.e.mean, 0.005 + 0.002 + c.e.mean * (spread + c.e.sd * c.e.sd));
    near(Quantity::mu, c.mu.mean, 0.005 + 0.003 + left / (c.vy_lo_mps.mean - c.vy_td_mps.mean));
  }
}

TEST(ThesisScenes, LeaveLittleOfThePublishedLiftOff) {
  // What the mechanics cannot reach with coefficients near those of all conditions: three sets, of which
  // back_17 and top_71 are those that every model of the impact misses most.
  int reached = 0;
  for (const auto& c : conditions()) {
    const FittedScene& fitted = fitted_of(c);
    const double vx_z = std::abs(fitted.left_vx_mps) / c.vx_lo_mps.sd;
    const double spin_z = std::abs(fitted.left_omega_radps) / c.omega_lo_radps.sd;
    if (vx_z < 0.02 && spin_z < 0.02) ++reached;
    CHECK_TEXT(vx_z < 1.5 && spin_z < 1.5, c.name().c_str());
  }
  CHECK(reached >= 18);
}

TEST(ThesisScenes, SlideThroughoutOnlyWhereTheThesisBallsDid) {
  for (const auto& c : conditions()) {
    const bool slides = c.name() == "zero_17" || c.name() == "back_17" || c.name() == "back_22";
    Scene scene = scene_of(c);
    test::make_exact(scene);
    const auto path = BallPath::make(scene, draw_shot_conditions(scene, 1, 1));
    CHECK_TEXT((path->rebound().regime == Regime::slides) == slides, c.name().c_str());
  }
}

TEST(ThesisScenes, TravelDuringContactAboutAsFarAsMeasured) {
  // The dwell distance is not fitted. It follows from the dwell time and the friction's course; the tables'
  // own scatter (up to .58 cm) and a mean velocity between vx_TD and vx_LO bound it.
  for (const auto& c : conditions()) {
    const double distance_cm = *exact_truth(scene_of(c))[Quantity::dwell_distance_cm];
    const double longest = c.vx_td_mps.mean * c.dwell_time_ms.mean / 10.0;
    const double shortest = c.vx_lo_mps.mean * c.dwell_time_ms.mean / 10.0;
    CHECK_TEXT(distance_cm < longest && distance_cm > shortest, c.name().c_str());
    CHECK_TEXT(std::abs(distance_cm - c.dwell_distance_cm.mean) < 0.15 * c.dwell_distance_cm.mean + 0.2,
               fmt::format("{}: {} for {}", c.name(), distance_cm, c.dwell_distance_cm.mean).c_str());
  }
}

TEST(ThesisScenes, KeepTheTabletsNoiseWithinHandsReachAndBelowEveryPublishedSpread) {
  for (const auto& c : conditions()) {
    const Scene scene = scene_of(c);
    CHECK(scene.tablet.centre_sd_m > 0.05e-3 && scene.tablet.centre_sd_m <= 0.5e-3);
    CHECK(scene.tablet.equator_sd_rad > 0.0 &&
          scene.tablet.equator_sd_rad <= std::numbers::pi / 180.0 + 1e-9);
    const double two_point_mps = std::numbers::sqrt2 * scene.tablet.centre_sd_m / 0.003;
    const double two_point_radps = std::numbers::sqrt2 * scene.tablet.equator_sd_rad / 0.003;
    for (const auto& published : {c.vx_td_mps, c.vy_td_mps, c.v_td_mps, c.vx_lo_mps, c.vy_lo_mps, c.v_lo_mps})
      CHECK_TEXT(two_point_mps <= published.sd, c.name().c_str());
    CHECK(two_point_radps <= c.omega_td_radps.sd && two_point_radps <= c.omega_lo_radps.sd);
  }
}

TEST(ThesisScenes, SpreadTwoPointReadingsAsPublished) {
  for (const auto& c : conditions()) {
    const FittedScene& fitted = fitted_of(c);
    const auto& [in, out] = series_of(c);
    check_sd(c.name() + " v_td", c.v_td_mps, in.v, 0.005);
    check_sd(c.name() + " theta_in", c.theta_in_deg, in.angle, 0.005);
    check_sd(c.name() + " omega_td", c.omega_td_radps, in.spin, 0.05);
    check_sd_or_miss(c.name() + " vx_lo", fitted, Quantity::vx_lo_mps, c.vx_lo_mps, out.vx, 0.005);
    check_sd_or_miss(c.name() + " vy_lo", fitted, Quantity::vy_lo_mps, c.vy_lo_mps, out.vy, 0.005);
    check_sd_or_miss(c.name() + " omega_lo", fitted, Quantity::omega_lo_radps, c.omega_lo_radps, out.spin,
                     0.05);
  }
}

TEST(ThesisScenes, SpreadWhatWasNotFittedCredibly) {
  // Components at touchdown, speed and angle at lift-off follow from the fitted spreads; the published ones
  // are those of 8 to 12 shots.
  for (const auto& c : conditions()) {
    const auto& [in, out] = series_of(c);
    const auto check = [&](const char* what, const thesis::MeanSd& published, const Moments& simulated,
                           int n) {
      CHECK_TEXT(credible(published.sd, simulated.sd(), n),
                 fmt::format("{} {}: published sd {} of {}, simulated {:.3f}", c.name(), what, published.sd,
                             n, simulated.sd())
                     .c_str());
    };
    check("vx_td", c.vx_td_mps, in.vx, c.n_incoming);
    check("vy_td", c.vy_td_mps, in.vy, c.n_incoming);
    check("v_lo", c.v_lo_mps, out.v, c.n_rebound);
    check("theta_out", c.theta_out_deg, out.angle, c.n_rebound);
    check("vx_lo", c.vx_lo_mps, out.vx, c.n_rebound);
    check("vy_lo", c.vy_lo_mps, out.vy, c.n_rebound);
    check("omega_lo", c.omega_lo_radps, out.spin, c.n_rebound);
  }
}
