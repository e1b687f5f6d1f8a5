#include "host/design/design_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/units/angles.hpp"
#include "host/design/digitizer_noise.hpp"
#include "host/design/exposure.hpp"
#include "host/design/optics.hpp"
#include "host/session/shot_table.hpp"
#include "host/text/text.hpp"
#include "host/view/series_view.hpp"

namespace strobe::host {
namespace {

using nlohmann::ordered_json;
using reduction::kQuantityCount;
using reduction::Quantity;
using Lines = std::vector<std::string>;

constexpr std::string_view kIndent = "        ";
constexpr std::size_t kPartsShown = 2;
// A spread that is less of one shot's uncertainty is none.
constexpr double kNoSpread = 0.01;

const QuantityLabel& label(Quantity q) { return kQuantityLabels[static_cast<std::size_t>(q)]; }

std::string with_unit(Quantity q, const std::string& number) {
  return label(q).unit.empty() ? number : fmt::format("{} {}", number, label(q).unit);
}

std::string spread_words(const Spread& s, double unit, std::string_view name) {
  return s.sd > 0.0 ? fmt::format("{:.4g} ± {:.2g} {}", unit * s.mean, unit * s.sd, name)
                    : fmt::format("{:.4g} {}", unit * s.mean, name);
}

std::string ball_line(const ExpectedBall& b) {
  return fmt::format("ball    {}, {}, {}; {}, {}, {}", spread_words(b.speed_mps, 1.0, "m/s"),
                     spread_words(b.angle_rad, 180.0 / kPi, "degrees"),
                     spread_words(b.spin_radps, 1.0, "rad/s"), spread_words(b.e, 1.0, "e"),
                     spread_words(b.mu, 1.0, "mu"), spread_words(b.dwell_s, 1e3, "ms in contact"));
}

std::string camera_line(const SetUp& s) {
  std::string line = fmt::format("camera  {:.0f} px/m", s.px_per_m);
  line += s.camera.px_per_m_sd ? fmt::format(" ± {:.2g} %", 100.0 * *s.camera.px_per_m_sd / s.px_per_m)
                               : std::string(", refined by the ball's diameter on each photograph");
  line += fmt::format("; {:.0f} x {:.0f} px{}, {:.2f} x {:.2f} m", s.width_px, s.height_px,
                      s.size_assumed ? " (assumed: camera.width_px and height_px say it)" : "",
                      s.width_px / s.px_per_m, s.height_px / s.px_per_m);
  return line + (s.measured_by == MeasuredBy::hand ? "; measured by hand" : "; measured by the digitizer");
}

std::string range_words(const std::array<int, 2>& range) {
  return range[0] == range[1] ? std::to_string(range[0]) : fmt::format("{} to {}", range[0], range[1]);
}

std::string train_line(const PlanFile& plan, const std::string& remark, const Prediction& p) {
  std::string line = "train   ";
  line += remark.empty()
              ? (plan.intervals.empty()
                     ? fmt::format("a flash every {:.4g} ms", 1e3 * to_seconds(plan.even.period))
                     : fmt::format("{} intervals of its own, {:.4g} ms the shortest", plan.intervals.size(),
                                   1e3 * to_seconds(*std::ranges::min_element(plan.intervals))))
              : remark;
  return line + fmt::format("; {} images before the bounce, {} after", range_words(p.incoming),
                            range_words(p.rebound));
}

/// What the lens does off the plane, and whether a flash's light suits.
void add_optics(const DesignReport& r, Lines& lines) {
  constexpr double kOffPlane_m = 0.01;
  const SetUp& s = r.design.set_up;
  if (const auto& lens = s.lens) {
    const DepthOfField sharp = depth_of_field(*lens, 1.0);
    lines.push_back(fmt::format(
        "lens    {:g} mm at f/{:g}, {:.4g} m away: sharp to a px from {:.4g} to {:.4g} m; {:.0f} mm off the "
        "plane: blur {:.2f} px, scale {:.2f} %; diffraction {:.2f} px",
        lens->focal_length_mm, lens->f_number, lens->distance_m, sharp.near_m, sharp.far_m, 1e3 * kOffPlane_m,
        defocus_sd_px(*lens, kOffPlane_m), 100.0 * 1e3 * kOffPlane_m * perspective_per_mm(*lens),
        diffraction_sd_px(*lens)));
  }
  if (s.measured_by == MeasuredBy::hand) return;
  const double motion = r.design.ball.speed_mps.mean * s.picture.flash_s * s.px_per_m;
  const int most = r.prediction.most_at_one_place;
  std::string line =
      fmt::format("light   a ball moves {:.2f} px in a flash of {:g} us; {}", motion, 1e6 * s.picture.flash_s,
                  most > 1 ? fmt::format("up to {} images lie on one place", most) : "no images overlap");
  const auto advice =
      exposure_advice(PhotographedLight{std::min(1.0, kLightestFelt * s.picture.exposure), 0.0, std::nullopt},
                      std::max(1, most));
  if (advice) line += ": " + advice->words;
  lines.push_back(std::move(line));
}

void add_readable(const Prediction& p, Lines& lines) {
  if (!p.spins_known())
    lines.push_back(fmt::format(
        "! spins are not told: {} of {} balls would be read with another one; shorter or other intervals "
        "tell them apart",
        p.aliased, p.readable));
  if (p.readable == p.balls) return;
  lines.push_back(fmt::format("! {} of {} expected balls can be read", p.readable, p.balls));
  for (const auto& [why, count] : p.reasons) lines.push_back(fmt::format("  {} of them: {}", count, why));
}

std::string parts_words(const PredictedQuantity& q, std::size_t most) {
  std::string words;
  for (std::size_t i = 0; i < std::min(most, q.budget.size()); ++i) {
    if (q.budget[i].share < 0.01) break;
    words += fmt::format("{}{} {:.0f} %", i == 0 ? "" : ", ", q.budget[i].source, 100.0 * q.budget[i].share);
  }
  return words;
}

bool is_row(const DesignReport& r, Quantity q, bool all) {
  return all || is_essential(q) || std::ranges::find(r.quantities, q) != r.quantities.end();
}

void add_table(const DesignReport& r, bool all, Lines& lines) {
  lines.push_back(left("", kNameWidth) + left("unit", kUnitWidth) + right("expected", kNumberWidth) +
                  right("one shot u", kNumberWidth + 1) + right("of balls", kNumberWidth) +
                  right(fmt::format("{} shots ± 95 %", r.design.shots), kNumberWidth + 9) +
                  "  one shot's parts");
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto& p = r.prediction.of(q);
    if (!p || !is_row(r, q, all)) continue;
    const double expanded = p->expanded(r.design.shots);
    lines.push_back(
        left(label(q).words, kNameWidth) + left(label(q).unit, kUnitWidth) +
        right(rounded(p->mean, p->shot_sd), kNumberWidth) +
        right(rounded(p->shot_sd, p->shot_sd), kNumberWidth + 1) +
        right(p->spread > kNoSpread * p->shot_sd ? rounded(p->spread, p->spread) : "-", kNumberWidth) +
        right(rounded(expanded, expanded), kNumberWidth + 9) + "  " +
        parts_words(*p, all ? p->budget.size() : kPartsShown));
  }
  lines.push_back("(u: total standard uncertainty; of balls: how true numbers differ from ball to ball)");
}

void add_needs(const DesignReport& r, Lines& lines) {
  for (const Need& need : r.needs) {
    const std::string size = with_unit(need.quantity, fmt::format("{:.3g}", need.half_width));
    const std::string what =
        need.is_difference ? fmt::format("to find a difference of {} in {}", size, label(need.quantity).words)
                           : fmt::format("for {} ± {} (95 %)", label(need.quantity).words, size);
    if (need.shots)
      lines.push_back(fmt::format("{}: {} shots{}", what, *need.shots, need.is_difference ? " of each" : ""));
    else
      lines.push_back(fmt::format("{}: no number of shots would do; what they share is too uncertain", what));
  }
}

void add_improvements(const DesignReport& r, Lines& lines) {
  if (r.improvements.empty()) return;
  std::string names;
  for (const Quantity q : r.quantities) names += (names.empty() ? "" : ", ") + std::string(label(q).words);
  lines.push_back(fmt::format("What would help most ({}; each by itself):", names));
  for (const Improvement& one : r.improvements)
    lines.push_back(fmt::format("  {:5.2f} times as certain: {}", one.gain, one.what));
}

void add_best(const DesignReport& r, Lines& lines) {
  if (!r.best) return;
  if (!r.best->remark.empty()) {
    lines.push_back(fmt::format("best train: {} ({} tried)", r.best->remark, r.best->tried));
    return;
  }
  lines.push_back(fmt::format(
      "best of {} trains: {:.2f} times as certain as this one but for scale and ball; {:.2f} times "
      "with them",
      r.best->tried, r.best->gain, gain(r.prediction, r.best->prediction, r.quantities)));
  lines.push_back(train_line(r.best->plan, "", r.best->prediction));
}

ordered_json spread_json(const Spread& s, double unit) {
  return {{"mean", unit * s.mean}, {"sd", unit * s.sd}};
}

ordered_json quantity_json(const PredictedQuantity& p, int shots) {
  ordered_json budget = ordered_json::array();
  for (const BudgetLine& line : p.budget)
    budget.push_back(
        {{"source", line.source}, {"effect", line.effect}, {"share", line.share}, {"shared", line.shared}});
  return {{"expected", p.mean},          {"spread", p.spread},
          {"shot_sd", p.shot_sd},        {"shared_sd", p.shared_sd},
          {"mean_sd", p.mean_sd(shots)}, {"expanded_uncertainty", p.expanded(shots)},
          {"budget", std::move(budget)}};
}

ordered_json prediction_json(const Prediction& p, int shots) {
  ordered_json quantities = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i)
    if (const auto& q = p.quantities[i])
      quantities[std::string(reduction::kQuantityNames[i])] = quantity_json(*q, shots);
  return {{"balls", p.balls},
          {"readable", p.readable},
          {"not_readable", p.reasons},
          {"spin_aliased", p.aliased},
          {"images_incoming", p.incoming},
          {"images_rebound", p.rebound},
          {"largest_overlap", p.largest_overlap},
          {"quantities", std::move(quantities)}};
}

}  // namespace

Lines render_design(const DesignReport& r, std::size_t width, bool all) {
  Lines head{ball_line(r.design.ball), camera_line(r.design.set_up),
             train_line(r.design.plan, r.train_remark, r.prediction)};
  add_optics(r, head);
  head.insert(head.end(), r.remarks.begin(), r.remarks.end());
  Lines lines;
  for (const std::string& line : head)
    for (std::string& part : wrapped(line, width, kIndent)) lines.push_back(std::move(part));
  add_readable(r.prediction, lines);
  if (r.prediction.readable > 0) add_table(r, all, lines);
  add_needs(r, lines);
  add_best(r, lines);
  add_improvements(r, lines);
  return all ? lines : fitted(std::move(lines), width);
}

ordered_json design_json(const DesignReport& r) {
  const ExpectedBall& b = r.design.ball;
  const SetUp& s = r.design.set_up;
  ordered_json out{{"inputs",
                    {{"speed_mps", spread_json(b.speed_mps, 1.0)},
                     {"angle_deg", spread_json(b.angle_rad, 180.0 / kPi)},
                     {"spin_radps", spread_json(b.spin_radps, 1.0)},
                     {"e", spread_json(b.e, 1.0)},
                     {"mu", spread_json(b.mu, 1.0)},
                     {"dwell_ms", spread_json(b.dwell_s, 1e3)},
                     {"ball_diameter_m", b.ball.diameter_m},
                     {"px_per_m", s.px_per_m},
                     {"width_px", s.width_px},
                     {"height_px", s.height_px},
                     {"measured_by", s.measured_by == MeasuredBy::hand ? "hand" : "digitizer"},
                     {"shots", r.design.shots}}},
                   {"plan", plan_to_toml(r.design.plan)}};
  out.update(prediction_json(r.prediction, r.design.shots));
  out["needs"] = ordered_json::array();
  for (const Need& need : r.needs)
    out["needs"].push_back({{"quantity", reduction::name(need.quantity)},
                            {need.is_difference ? "difference" : "half_width", need.half_width},
                            {"shots", need.shots ? ordered_json(*need.shots) : ordered_json(nullptr)}});
  if (r.best) {
    out["best_train"] = prediction_json(r.best->prediction, r.design.shots);
    out["best_train"]["plan"] = plan_to_toml(r.best->plan);
    out["best_train"]["gain"] = r.best->gain;
    out["best_train"]["total_gain"] = gain(r.prediction, r.best->prediction, r.quantities);
    out["best_train"]["tried"] = r.best->tried;
  }
  if (!r.remarks.empty()) out["remarks"] = r.remarks;
  out["improvements"] = ordered_json::array();
  for (const Improvement& one : r.improvements)
    out["improvements"].push_back({{"what", one.what}, {"gain", one.gain}});
  return out;
}

}  // namespace strobe::host
