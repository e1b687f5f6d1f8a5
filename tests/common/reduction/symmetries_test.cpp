// A photograph seen otherwise, or in other units of length and time, tells the same: of bounces and single flights, by
// all estimators, with noise stated and estimated, with what a calibration leaves open.
#include <cmath>
#include <vector>

#include "common/reduction/uncertainty.hpp"
#include "tests/common/reduction/drawn_frames.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;
using strobe::testing::between;
using strobe::testing::holds_of_all;
using strobe::testing::one_in;
using strobe::testing::over_decades;
using strobe::testing::Worst;

namespace {

/// The fit ends within a millionth of an sd, noise that is estimated within a millionth of itself, and five times as
/// much may be made of either where a divisor is near zero.
constexpr double kShareOfSd = 1e-5;

/// How numbers change: by units of length and time, and by a mirror that the readout does not turn back.
struct Change {
  double length = 1.0, time = 1.0;
  bool turned_round = false;

  double factor(Quantity q) const {
    switch (q) {
      case Quantity::vx_td_mps:
      case Quantity::vx_lo_mps:
      case Quantity::slip_lo_mps:
        return (turned_round ? -1.0 : 1.0) * length / time;
      case Quantity::vy_td_mps:
      case Quantity::vy_lo_mps:
      case Quantity::v_td_mps:
      case Quantity::v_lo_mps:
        return length / time;
      case Quantity::omega_td_radps:
      case Quantity::omega_lo_radps:
        return (turned_round ? -1.0 : 1.0) / time;
      case Quantity::mu:
        return turned_round ? -1.0 : 1.0;
      case Quantity::dwell_time_ms:
        return time;
      case Quantity::dwell_distance_cm:
        return (turned_round ? -1.0 : 1.0) * length;
      default:
        return 1.0;
    }
  }

  double of(Quantity q, double value) const {
    if (turned_round && (q == Quantity::theta_in_deg || q == Quantity::theta_out_deg))
      return std::copysign(180.0, value) - value;
    return factor(q) * value;
  }
};

/// What digitizing by hand leaves uncertain, in the order of Quantity: the unit of numbers that have no sd.
constexpr std::array<double, kQuantityCount> kByHand{0.1, 0.1, 0.05, 0.05, 0.05, 1.0,  0.05, 0.05,
                                                     0.05, 1.0, 0.05, 0.01, 0.01, 0.1, 0.1,  1.0};

void same(const Numbers& before, const Numbers& after, const Change& change, Worst& worst) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto told = [q](const Numbers& numbers) {
      return std::to_string(numbers.value[q].value_or(NAN)) + " +- " + std::to_string(numbers.sd[q].value_or(NAN));
    };
    RC_LOG() << kQuantityNames[i] << ": " << told(before) << ", then " << told(after) << '\n';
    RC_ASSERT(before.value[q].has_value() == after.value[q].has_value());
    RC_ASSERT(before.sd[q].has_value() == after.sd[q].has_value());
    RC_ASSERT(before.sd_systematic[q].has_value() == after.sd_systematic[q].has_value());
    if (!before.value[q]) continue;
    const double size = std::abs(change.factor(q));
    const double unit = size * before.sd[q].value_or(kByHand[i] + std::abs(*before.value[q]));
    RC_ASSERT(worst.within(std::abs(*after.value[q] - change.of(q, *before.value[q])) / unit, kShareOfSd));
    if (!before.sd[q]) continue;
    RC_ASSERT(worst.within(std::abs(*after.sd[q] - size * *before.sd[q]) / unit, kShareOfSd));
    if (before.sd_systematic[q])
      RC_ASSERT(worst.within(std::abs(*after.sd_systematic[q] - size * *before.sd_systematic[q]) / unit, kShareOfSd));
  }
}

void same(const Readout& before, const Readout& after, const Change& change, Worst& worst) {
  for (std::size_t i = 0; i < kFlagCount; ++i) {
    const auto flag = static_cast<Flag>(i);
    RC_LOG() << kFlagNames[i] << '\n';
    RC_ASSERT(before.flags.has(flag) == after.flags.has(flag));
  }
  RC_ASSERT(before.regime == after.regime);
  RC_ASSERT(before.flight_effects == after.flight_effects);
  RC_ASSERT(before.launch.has_value() == after.launch.has_value());
  same(static_cast<const Numbers&>(before), after, change, worst);
  if (before.launch) same(*before.launch, *after.launch, change, worst);
}

Readout read(const Frame& frame, Estimator estimator, std::optional<flight::Effects> effects = {}) {
  const auto readout = reduce(frame, estimator, {.effects = effects});
  RC_ASSERT(readout.has_value());
  return *readout;
}

std::vector<Estimator> estimators(const Frame& frame) {
  if (frame.surface_px.empty()) return {Estimator::best};
  return {Estimator::best, Estimator::two_point};
}

/// Of those that the thesis's program keeps, whose tilt has the wrong sign and whose spin is biased to one side.
std::vector<Estimator> estimators_and_legacy(const Frame& frame) {
  std::vector<Estimator> all = estimators(frame);
  if (!frame.surface_px.empty()) all.push_back(Estimator::legacy);
  return all;
}

Frame drawn() { return one_in(5) ? any_flight() : any_frame(); }

Frame mirrored(Frame frame) {
  for (PointPx& p : frame.surface_px) p.x = -p.x;
  for (BallImage& image : frame.images) {
    image.centre_px.x = -image.centre_px.x;
    if (image.equator_rad) *image.equator_rad = -*image.equator_rad;
    if (image.centre_cov_px2) (*image.centre_cov_px2)[1] *= -1.0, (*image.centre_cov_px2)[2] *= -1.0;
  }
  for (MapError& error : frame.map_errors) {
    for (PointPx& p : error.surface_px) p.x = -p.x;
    for (MapError::Shift& s : error.images) s.centre_px.x = -s.centre_px.x, s.equator_rad = -s.equator_rad;
  }
  frame.surface_angle_deg = -frame.surface_angle_deg;
  return frame;
}

/// Turned about the photograph's origin, enlarged, and shifted.
struct Similarity {
  double angle_rad = 0.0, scale = 1.0;
  PointPx shift;

  PointPx turned(const PointPx& p) const {
    const double c = scale * std::cos(angle_rad), s = scale * std::sin(angle_rad);
    return {c * p.x - s * p.y, s * p.x + c * p.y};
  }
  PointPx operator()(const PointPx& p) const {
    const PointPx q = turned(p);
    return {q.x + shift.x, q.y + shift.y};
  }

  /// R C R^T.
  std::array<double, 4> covariance(const std::array<double, 4>& c) const {
    const PointPx left = turned({c[0], c[2]}), right = turned({c[1], c[3]});
    const PointPx top = turned({left.x, right.x}), bottom = turned({left.y, right.y});
    return {top.x, top.y, bottom.x, bottom.y};
  }
};

Frame seen(Frame frame, const Similarity& by) {
  for (PointPx& p : frame.surface_px) p = by(p);
  for (BallImage& image : frame.images) {
    image.centre_px = by(image.centre_px);
    image.diameter_px *= by.scale;
    if (image.diameter_sd_px) *image.diameter_sd_px *= by.scale;
    if (image.equator_rad) *image.equator_rad += by.angle_rad;
    if (image.centre_cov_px2) image.centre_cov_px2 = by.covariance(*image.centre_cov_px2);
  }
  for (MapError& error : frame.map_errors) {
    for (PointPx& p : error.surface_px) p = by.turned(p);
    for (MapError::Shift& s : error.images) s.centre_px = by.turned(s.centre_px), s.diameter_px *= by.scale;
  }
  for (auto* length : {&frame.centre_sd_px, &frame.surface_sd_px, &frame.diameter_sd_px,
                       &frame.shared_diameter_sd_px, &frame.px_per_m, &frame.px_per_m_sd})
    if (*length) **length *= by.scale;
  return frame;
}

/// Of a world so much larger and slower: its air as dense for its size.
Frame in_units(Frame frame, double length, double time) {
  const double start_s = frame.images.front().time_s;
  frame.ball_diameter_m *= length;
  if (frame.ball_diameter_sd_m) *frame.ball_diameter_sd_m *= length;
  if (frame.px_per_m) *frame.px_per_m /= length, *frame.px_per_m_sd /= length;
  for (BallImage& image : frame.images) {
    image.time_s = start_s + time * (image.time_s - start_s);
    if (image.time_sd_s) *image.time_sd_s *= time;
  }
  if (frame.fastest_spin_radps) *frame.fastest_spin_radps /= time;
  *frame.ball_mass_kg *= length * length;
  *frame.air_density_kgpm3 /= length;
  return frame;
}

}  // namespace

TEST_GROUP(Symmetries){};

// Without the court pace, another number where mu has another sign.
TEST(Symmetries, TheMirrorImageTellsTheSameOrTurnedRoundWhereTheBallHasNoDirection) {
  CHECK(holds_of_all([](Worst& worst) {
    Frame frame = drawn();
    frame.temperature_c.reset();
    for (const Estimator estimator : estimators(frame)) {
      const Readout right = read(frame, estimator), left = read(mirrored(frame), estimator);
      RC_ASSERT(!(left.mirrored && right.mirrored));
      same(right, left, {.turned_round = left.mirrored == right.mirrored}, worst);
    }
  }));
}

// Less than the quarter turn, with the roll, at which up becomes down.
TEST(Symmetries, TurningShiftingAndEnlargingThePhotographChangesNothing) {
  CHECK(holds_of_all([](Worst& worst) {
    const Frame frame = drawn();
    const double scale = over_decades(1e-3, 1e3);
    const Similarity by{frame.surface_px.empty() ? 0.0 : between(-1.0, 1.0), scale,
                        {scale * between(-1e4, 1e4), scale * between(-1e4, 1e4)}};
    for (const Estimator estimator : estimators_and_legacy(frame)) {
      const double angle_rad = estimator == Estimator::legacy ? 0.0 : by.angle_rad;
      same(read(frame, estimator), read(seen(frame, {angle_rad, scale, by.shift}), estimator), {}, worst);
    }
  }));
}

// A picosecond of rounding: 40 m/s make 1e-7 of 0.5 mm of it.
TEST(Symmetries, AnotherOriginOfTimeChangesNothing) {
  CHECK(holds_of_all([](Worst& worst) {
    const Frame frame = drawn();
    Frame later = frame;
    const double shift_s = between(-1e4, 1e4);
    for (BallImage& image : later.images) image.time_s += shift_s;
    for (const Estimator estimator : estimators_and_legacy(frame))
      same(read(frame, estimator), read(later, estimator), {}, worst);
  }));
}

TEST(Symmetries, TheOrderOfTheSurfacePointsIsNoneAndThatOfImagesIsTheirTimes) {
  CHECK(holds_of_all([](Worst& worst) {
    const Frame frame = any_frame();
    Frame other = frame;
    const auto by = static_cast<std::ptrdiff_t>(whole(1, static_cast<int>(frame.surface_px.size()) - 1));
    const auto rotate = [&](std::vector<PointPx>& points) {
      std::rotate(points.begin(), points.begin() + by, points.end());
      std::swap(points.front(), points.back());
    };
    rotate(other.surface_px);
    for (MapError& error : other.map_errors) rotate(error.surface_px);
    for (const Estimator estimator : estimators_and_legacy(frame))
      same(read(frame, estimator), read(other, estimator), {}, worst);
    const auto at = static_cast<std::size_t>(whole(1, static_cast<int>(frame.images.size()) - 1));
    std::swap(other.images[at - 1], other.images[at]);
    const auto refused = reduce(other, Estimator::best);
    RC_ASSERT(!refused.has_value());
    RC_ASSERT(refused.error().message.starts_with("images[" + std::to_string(at) + "].time_s: must be later"));
  }));
}

/// Both spins are told. Else the fastest that balls fly with bounds what they may be, in m/s.
bool spins_are_told(const Readout& readout) {
  const Numbers& numbers = readout.launch ? static_cast<const Numbers&>(*readout.launch) : readout;
  return numbers.value[Quantity::omega_td_radps] &&
         (readout.launch || numbers.value[Quantity::omega_lo_radps]) && !readout.flags.has(Flag::spin_aliased);
}

// Gravity is as it was where time goes with the root of length. The air's pull over a length is its density over the
// ball's, which has a surface for its mass.
TEST(Symmetries, ALargerSlowerWorldUnderTheSameGravityTellsTheSame) {
  CHECK(holds_of_all([](Worst& worst) {
    const Frame frame = drawn();
    const double length = over_decades(0.8, 1.25), time = std::sqrt(length);
    const Readout before = read(frame, Estimator::best), after = read(in_units(frame, length, time), Estimator::best);
    RC_PRE(spins_are_told(before) && spins_are_told(after));
    same(before, after, {length, time}, worst);
  }));
}

// With the same speeds, since the fastest that balls fly with bounds what their spins may be. Which image overlaps the
// surface is asked with gravity whatever the fit has.
TEST(Symmetries, WithoutGravityAndAirAWorldAsMuchLargerAsSlowerTellsTheSame) {
  CHECK(holds_of_all([](Worst& worst) {
    const Frame frame = drawn();
    RC_PRE(frame.surface_px.empty() || frame.images.front().leg.has_value());
    const double factor = over_decades(0.5, 2.0);
    for (const Estimator estimator : estimators_and_legacy(frame)) {
      const Readout before = read(frame, estimator, flight::kNoEffects);
      const Readout after = read(in_units(frame, factor, factor), estimator, flight::kNoEffects);
      RC_PRE(!before.flags.has(Flag::overlaps_surface) && !after.flags.has(Flag::overlaps_surface));
      same(before, after, {factor, factor}, worst);
    }
  }));
}

TEST(Symmetries, NoiseThatIsStatedForTheFrameIsThatOfEachImage) {
  CHECK(holds_of_all([](Worst& worst) {
    const Frame frame = drawn();
    Frame each = frame;
    for (BallImage& image : each.images) {
      if (image.centre_cov_px2 || !frame.centre_sd_px) continue;
      const double variance = *frame.centre_sd_px * *frame.centre_sd_px;
      image.centre_cov_px2 = {variance, 0.0, 0.0, variance};
      image.diameter_sd_px = frame.diameter_sd_px;
      image.equator_sd_rad = frame.equator_sd_rad;
    }
    for (const Estimator estimator : estimators(frame)) same(read(frame, estimator), read(each, estimator), {}, worst);
  }));
}

// But that there are some, and where they contradict the line.
TEST(Symmetries, NoNumberHangsOnTheLabelledImagesInContact) {
  CHECK(holds_of_all([](Worst& worst) {
    const Frame frame = any_frame();
    RC_PRE(frame.images.front().leg.has_value());
    Frame without = frame;
    for (std::size_t i = without.images.size(); i-- > 0;) {
      if (without.images[i].leg != Leg::contact) continue;
      const auto at = static_cast<std::ptrdiff_t>(i);
      without.images.erase(without.images.begin() + at);
      for (MapError& error : without.map_errors) error.images.erase(error.images.begin() + at);
    }
    for (const Estimator estimator : estimators(frame)) {
      const Readout with = read(frame, estimator), after = read(without, estimator);
      same(static_cast<const Numbers&>(with), after, {}, worst);
    }
  }));
}

// The budget moves each input by a tenth of its sd: 1e-6 sd at which the fit ends is 1e-5 of an effect.
TEST(Symmetries, TheBudgetIsThatOfTheMirroredTurnedAndEnlargedPhotograph) {
  CHECK(holds_of_all([](Worst& worst) {
    Frame frame = drawn();
    frame.temperature_c.reset();  // no court pace: see the mirror image
    const double scale = over_decades(1e-2, 1e2);
    const Similarity by{frame.surface_px.empty() ? 0.0 : between(-1.0, 1.0), scale, {scale * 300.0, scale * -200.0}};
    for (const Estimator estimator : estimators(frame)) {
      const auto before = uncertainty_budget(frame, estimator);
      const Readout readout = read(frame, estimator);
      const Numbers& numbers = readout.launch ? static_cast<const Numbers&>(*readout.launch) : readout;
      for (const Frame& other : {seen(frame, by), mirrored(frame)}) {
        const auto after = uncertainty_budget(other, estimator);
        RC_ASSERT(before.has_value() && after.has_value());
        for (const BudgetSource& source : before->sources) {
          const auto same_source = std::ranges::find_if(after->sources, [&](const BudgetSource& s) {
            return s.source == source.source && s.number == source.number;
          });
          for (std::size_t i = 0; i < kQuantityCount; ++i) {
            const auto q = static_cast<Quantity>(i);
            if (!numbers.sd[q]) continue;
            RC_LOG() << name_of(source) << " of " << kQuantityNames[i] << '\n';
            const double then = same_source == after->sources.end() ? 0.0 : same_source->of(q);
            RC_ASSERT(worst.within(std::abs(std::abs(then) - std::abs(source.of(q))) / *numbers.sd[q], 5e-5));
          }
        }
      }
    }
  }));
}
