#include "host/design/improvements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/assembly/coded_spacing.hpp"

namespace strobe::host {
namespace {

constexpr PredictionOptions kQuick{.balls = 32, .budgets = 8, .match = false};
constexpr double kWorthTelling = 1.01;
constexpr double kLongerLens = 1.5;
// What a careful laboratory reaches: a board known to .05 % over its width, a ball between callipers, stamps
// of a photodiode with a fast comparator.
constexpr double kGoodScaleShare = 0.0005;
constexpr double kCallipersSd_m = 0.00005;
constexpr double kGoodStampSd_s = 0.1e-6;
constexpr int kMoreShots = 6;

struct Variant {
  std::string what;
  Design design;
};

std::vector<double> expanded_of(const Prediction& p, int shots,
                                std::span<const reduction::Quantity> quantities) {
  std::vector<double> values;
  for (const reduction::Quantity q : quantities) {
    const auto& quantity = p.of(q);
    values.push_back(quantity && p.readable > 0 ? quantity->expanded(shots)
                                                : std::numeric_limits<double>::quiet_NaN());
  }
  return values;
}

std::string lens_words(const SetUp& s, double factor) {
  const double px_per_m = factor * s.px_per_m;
  std::string words = fmt::format("a lens {:.2g} times as long", factor);
  if (s.lens) words += fmt::format(", or this one at {:.2f} m", distance_for_scale_m(*s.lens, px_per_m));
  return words + fmt::format(": {:.0f} px/m, {:.2f} m are seen", px_per_m, s.width_px / px_per_m);
}

void add_set_up(const Design& now, std::vector<Variant>& variants) {
  const auto add = [&](std::string what, const auto& change) {
    Variant v{std::move(what), now};
    change(v.design);
    variants.push_back(std::move(v));
  };
  const SetUp& s = now.set_up;
  for (const double factor : {kLongerLens, 1.0 / kLongerLens})
    add(lens_words(s, factor), [factor](Design& d) { d.set_up = with_lens(d.set_up, factor); });
  const double good_scale_sd = kGoodScaleShare * s.px_per_m;
  if (!s.camera.px_per_m_sd || *s.camera.px_per_m_sd > good_scale_sd || !s.camera.map_errors.empty())
    add(fmt::format("a better board: the scale known to {:.2f} %", 100.0 * kGoodScaleShare), [&](Design& d) {
      d.set_up.camera.px_per_m_sd = good_scale_sd;
      d.set_up.camera.map_errors.clear();
    });
  if (s.ball_diameter_sd_m > kCallipersSd_m)
    add(fmt::format("the ball measured to {:.2f} mm", 1e3 * kCallipersSd_m),
        [](Design& d) { d.set_up.ball_diameter_sd_m = kCallipersSd_m; });
  if (s.flash_time_sd_s > kGoodStampSd_s)
    add(fmt::format("flash times stamped to {:.1f} us", 1e6 * kGoodStampSd_s),
        [](Design& d) { d.set_up.flash_time_sd_s = kGoodStampSd_s; });
  if (s.measured_by == MeasuredBy::hand)
    add("photographs measured by strobe digitize, not by hand",
        [](Design& d) { d.set_up.measured_by = MeasuredBy::digitizer; });
}

void add_series(const Design& now, std::vector<Variant>& variants) {
  Variant more{fmt::format("{} more balls: {}", kMoreShots, now.shots + kMoreShots), now};
  more.design.shots += kMoreShots;
  variants.push_back(std::move(more));
  Variant steady{"a machine that repeats twice as well", now};
  for (Spread* spread :
       {&steady.design.ball.speed_mps, &steady.design.ball.angle_rad, &steady.design.ball.spin_radps})
    spread->sd *= 0.5;
  variants.push_back(std::move(steady));
}

/// Flashes as fast as the lamps allow, or half as far apart.
void add_faster_train(const Design& now, const RigFile& rig, std::vector<Variant>& variants) {
  const Duration period = std::max(now.set_up.shortest_interval(), now.plan.even.period / 2);
  if (period >= now.plan.even.period) return;
  PlanFile plan = now.plan;
  plan.even.period = period;
  plan.spacing = plan.intervals.empty() ? Spacing::even : Spacing::coded;
  plan.intervals.clear();
  plan.omit.clear();
  if (plan.even.train == Train::gated)
    plan.even.flash_count = static_cast<int>(plan.even.flash_count * (now.plan.even.period / period));
  SpacedPlan spaced = spaced_plan(plan, rig, now.set_up.measured_by == MeasuredBy::digitizer);
  if (!spaced.problem.empty()) return;
  plan = std::move(spaced.plan);
  if (plan_problem(plan.shot(), now.set_up.limits)) return;
  Variant v{fmt::format("a flash every {:.3g} ms", 1e3 * to_seconds(period)), now};
  v.design.plan = std::move(plan);
  variants.push_back(std::move(v));
}

}  // namespace

Result<Prediction> predict(const Design& design, const PredictionOptions& options) {
  return predict(design.ball, design.set_up, expected_train(design.plan.shot(), design.set_up, design.ball),
                 options);
}

Result<std::vector<Improvement>> improvements(const Design& design, const RigFile& rig,
                                              std::span<const reduction::Quantity> quantities,
                                              const std::optional<PlanFile>& best) {
  std::vector<Variant> variants;
  add_set_up(design, variants);
  add_series(design, variants);
  add_faster_train(design, rig, variants);
  if (best) {
    Variant v{"the best train", design};
    v.design.plan = *best;
    variants.push_back(std::move(v));
  }
  const auto now = predict(design, kQuick);
  if (!now) return tl::unexpected(now.error());
  const std::vector<double> before = expanded_of(*now, design.shots, quantities);
  std::vector<Improvement> found;
  for (const Variant& v : variants) {
    const auto then = predict(v.design, kQuick);
    if (!then) return tl::unexpected(then.error());
    if (then->readable_share() < now->readable_share()) continue;
    Improvement one{v.what, expanded_of(*then, v.design.shots, quantities), 0.0};
    for (std::size_t i = 0; i < before.size(); ++i)
      one.gain += std::log(before[i] / one.expanded[i]) / static_cast<double>(before.size());
    one.gain = std::exp(one.gain);
    if (one.gain > kWorthTelling) found.push_back(std::move(one));
  }
  std::ranges::stable_sort(found, std::greater{}, &Improvement::gain);
  return found;
}

}  // namespace strobe::host
