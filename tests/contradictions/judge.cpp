#include "tests/contradictions/judge.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/reduction/uncertainty.hpp"

namespace strobe::contradictions {
namespace {

using reduction::kQuantityCount;
using reduction::Quantity;
using reduction::Readout;

using FlagNames = std::array<std::string_view, 10>;

/// The flags that explain a wrong number in this kind of trouble. By name, so that those to come can be told here first.
struct Explanation {
  Kind kind;
  FlagNames flags;
};

constexpr std::string_view kMisfit = "residuals_exceed_noise", kOutlier = "outlier_image",
                           kFew = "no_redundancy", kAliased = "spin_aliased",
                           kAssumed = "spin_limit_assumed",
                           kBall = "scale_contradicts_ball", kPoint = "outlier_surface_point",
                           kSurface = "surface_suspect", kOverlaps = "overlaps_surface",
                           kDegenerate = "degenerate_geometry";

constexpr std::array kExplanations{
    Explanation{Kind::none, {}},
    Explanation{Kind::unread_equators, {}},
    Explanation{Kind::long_period, {}},
    Explanation{Kind::surface_point, {kPoint, kSurface, kMisfit}},
    Explanation{Kind::surface_pair, {kPoint, kSurface, kMisfit, kOverlaps}},
    Explanation{Kind::scale, {kBall, kMisfit}},
    Explanation{Kind::ball_size, {kBall, kMisfit}},
    Explanation{Kind::ball_size_uncalibrated, {kBall, kMisfit}},
    Explanation{Kind::noise_understated, {kMisfit, kOutlier, kPoint, kSurface, kBall}},
    Explanation{Kind::noise_overstated, {}},
    Explanation{Kind::heavy_tails, {kMisfit, kOutlier, kPoint, kSurface, kBall}},
    Explanation{Kind::correlated, {kMisfit, kOutlier, kOverlaps}},
    Explanation{Kind::outlier_centre, {kOutlier, kMisfit, kOverlaps, kDegenerate}},
    Explanation{Kind::outlier_first_image, {kOutlier, kMisfit, kOverlaps, kDegenerate}},
    Explanation{Kind::outlier_diameter, {kOutlier, kMisfit, kBall}},
    Explanation{Kind::outlier_equator, {kOutlier, kMisfit}},
    Explanation{Kind::two_equators, {kOutlier, kMisfit}},
    Explanation{Kind::two_centres, {kOutlier, kMisfit, kOverlaps, kDegenerate}},
    Explanation{Kind::image_time, {kOutlier, kMisfit, kOverlaps, kDegenerate}},
    Explanation{Kind::time_noise, {kOutlier, kMisfit, kOverlaps}},
    Explanation{Kind::alpha, {}},
    Explanation{Kind::drag, {kMisfit}},
    Explanation{Kind::spin_decay, {kMisfit}},
    Explanation{Kind::surface_angle, {kOutlier, kMisfit}},
    Explanation{Kind::wrong_leg, {kOutlier, kMisfit, kSurface, kOverlaps, kDegenerate}},
    Explanation{Kind::gap, {}},
    Explanation{Kind::air, {}},
    Explanation{Kind::fast_spin, {kMisfit, kOutlier}},
    Explanation{Kind::fast_spin_coded, {kMisfit, kOutlier}},
    Explanation{Kind::tilted_axis, {kMisfit, kOutlier}},
    Explanation{Kind::tilted_axis_unmeasured, {kMisfit, kOutlier}},
    Explanation{Kind::off_plane, {kMisfit, kOutlier, kBall}},
};
static_assert(kExplanations.size() == kKindCount);

constexpr bool in_order() {
  for (std::size_t i = 0; i < kExplanations.size(); ++i)
    if (kExplanations[i].kind != static_cast<Kind>(i)) return false;
  return true;
}
static_assert(in_order());

bool contains(const FlagNames& names, std::string_view flag) {
  return std::find(names.begin(), names.end(), flag) != names.end();
}

bool follows_from_spin(Quantity q) {
  return q == Quantity::omega_td_radps || q == Quantity::omega_lo_radps || q == Quantity::slip_lo_mps;
}

bool has_flag(const Readout& readout, std::string_view flag) {
  const auto at = std::find(reduction::kFlagNames.begin(), reduction::kFlagNames.end(), flag);
  return at != reduction::kFlagNames.end() &&
         readout.flags.has(static_cast<reduction::Flag>(at - reduction::kFlagNames.begin()));
}

enum class Found { nothing, few, flag };

Found explanation(const Readout& readout, Quantity q, Kind kind, bool few) {
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const bool set = readout.flags.has(static_cast<reduction::Flag>(i));
    if (set && explains(reduction::kFlagNames[i], q, kind)) return Found::flag;
  }
  return few && has_flag(readout, kFew) ? Found::few : Found::nothing;
}

/// 6 sd; where the noise was estimated, as much wider as the interval that holds 95 % is.
double largest_error(const Readout& readout, Quantity q, double sd) {
  constexpr double kHalfWidth95 = 1.959963984540054;  // of a normal distribution
  if (!readout.degrees_of_freedom[q]) return kWrong_sd * sd;
  return kWrong_sd / kHalfWidth95 * reduction::expanded_uncertainty(readout, q).value_or(sd);
}

double sd_or_zero(const Readout& readout, Quantity q) {
  return reduction::total_sd(readout, q).value_or(0.0);
}

/// Of the change of vx that is missing, by its parts.
double missing_sd_mps(const Readout& readout, const Truth& truth) {
  const double share = truth.alpha / (1.0 + truth.alpha);
  return std::hypot((1.0 - share) * sd_or_zero(readout, Quantity::vx_td_mps),
                    sd_or_zero(readout, Quantity::vx_lo_mps),
                    share * truth.radius_m * sd_or_zero(readout, Quantity::omega_td_radps));
}

void judge_regime(const Readout& readout, const Truth& truth, Kind kind, bool few, Judgement& j) {
  if (!readout.regime || explanation(readout, Quantity::omega_td_radps, kind, few) != Found::nothing) return;
  // Rounding of a ball that rolls exactly.
  constexpr double kRounding_mps = 1e-9;
  j.slides_wrongly = *readout.regime == Regime::slides && truth.missing_mps < kRounding_mps;
  const double limit = std::max(kWrong_sd * missing_sd_mps(readout, truth), error_floor(Quantity::vx_td_mps));
  j.grips_wrongly = *readout.regime == Regime::grips && truth.missing_mps > limit;
}

}  // namespace

double error_floor(Quantity quantity) {
  // In the order of Quantity. Digitizing by hand: vx 0.24 m/s, e 0.047, mu 0.030, spin 8.2 rad/s, dwell 0.29 ms and
  // 3.7 mm; angles and the rest follow at 17 m/s.
  constexpr std::array<double, kQuantityCount> kFloors{0.08,   0.08,  0.024, 0.024, 0.024, 0.82,
                                                       0.024,  0.024, 0.024, 0.82,  0.036, 0.0047,
                                                       0.0030, 0.029, 0.037, 0.77};
  return kFloors[static_cast<std::size_t>(quantity)];
}

bool is_fact(std::string_view flag) {
  constexpr std::array<std::string_view, 5> kFacts{"no_contact_image", "no_redundancy", "too_few_images",
                                                   "sd_from_residuals", "scale_sd_unknown"};
  return std::find(kFacts.begin(), kFacts.end(), flag) != kFacts.end();
}

bool explains(std::string_view flag, Quantity quantity, Kind kind) {
  if (flag == kAssumed) return true;  // all is given for spins up to the limit
  if (flag == kAliased) return follows_from_spin(quantity);
  return contains(kExplanations[static_cast<std::size_t>(kind)].flags, flag);
}

Judgement judged(const Readout& readout, const Truth& truth, Kind kind, bool few) {
  Judgement j;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto sd = reduction::total_sd(readout, q);
    if (!readout.value[q] || !sd) continue;
    const double error = std::abs(*readout.value[q] - *truth.value[q]);
    if (!(error > std::max(largest_error(readout, q, *sd), error_floor(q)))) continue;
    const Found found = explanation(readout, q, kind, few);
    if (found == Found::flag) j.flagged.set(i);
    if (found == Found::few) j.few.set(i);
    if (found != Found::nothing) continue;
    j.silent.set(i);
    j.worst = std::max(j.worst, error / std::max(*sd, 1e-12));
  }
  judge_regime(readout, truth, kind, few, j);
  return j;
}

}  // namespace strobe::contradictions
