#include "tests/contradictions/report.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "common/messages/json_conversions.hpp"
#include "common/reduction/reduce.hpp"
#include "common/reduction/uncertainty.hpp"
#include "tests/contradictions/shot.hpp"

namespace strobe::contradictions {
namespace {

using Json = nlohmann::ordered_json;
using reduction::kFlagCount;
using reduction::kFlagNames;
using reduction::kQuantityCount;
using reduction::kQuantityNames;

double percent(std::int64_t count, std::int64_t of) {
  return of > 0 ? 100.0 * static_cast<double>(count) / static_cast<double>(of) : 0.0;
}

/// The three quantities that were wrong most often.
std::string most_wrong(const Tally& tally) {
  std::array<std::size_t, kQuantityCount> order{};
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, std::greater<>{},
                           [&](std::size_t i) { return tally.silent_by_quantity[i]; });
  std::string text;
  for (std::size_t k = 0; k < 3 && tally.silent_by_quantity[order[k]] > 0; ++k)
    text += fmt::format("{}{} {}", k > 0 ? ", " : "", kQuantityNames[order[k]],
                        tally.silent_by_quantity[order[k]]);
  return text;
}

std::string worst_shots(const std::vector<WorstShot>& worst) {
  std::string text;
  for (const WorstShot& w : worst)
    text += fmt::format("{}{} ({:.3g} sd)", text.empty() ? "" : ", ", w.number, w.error_sd);
  return text;
}

double rms_z(const Coverage& c) {
  return c.count > 0 ? std::sqrt(c.square / static_cast<double>(c.count)) : 0.0;
}

using reduction::kFlagCount;
using reduction::kQuantityCount;

constexpr std::size_t kWorstKept = 3;
/// Of a normal distribution.
constexpr double kOneSided95 = 1.6448536269514722;

void keep_worst(std::vector<WorstShot>& worst, const WorstShot& shot) {
  const auto worse = [](const WorstShot& a, const WorstShot& b) { return a.error_sd > b.error_sd; };
  worst.insert(std::upper_bound(worst.begin(), worst.end(), shot, worse), shot);
  if (worst.size() > kWorstKept) worst.pop_back();
}

void cover(const reduction::Readout& readout, const Truth& truth,
           std::array<Coverage, kQuantityCount>& coverage) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<reduction::Quantity>(i);
    const auto sd = reduction::total_sd(readout, q);
    const auto expanded = reduction::expanded_uncertainty(readout, q);
    if (!readout.value[q] || !sd || !expanded || !(*sd > 0.0)) continue;
    const double error = std::abs(*readout.value[q] - *truth.value[q]);
    const double z = error / *sd;
    Coverage& c = coverage[i];
    ++c.count;
    c.within_68 += z < 1.0 ? 1 : 0;
    c.within_95 += error < *expanded ? 1 : 0;
    c.square += z * z;
  }
}

}  // namespace

std::string table(const std::vector<Row>& rows) {
  std::string text =
      "| kind | shots | silently wrong, % (95 % limit) | likewise, beyond proof, % | "
      "told by no_redundancy only, % | wrong and flagged, % | \"slides\" of gripping, % | "
      "\"grips\" of sliding, % | which | worst shots |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [run, t] : rows)
    text += fmt::format(
        "| {} | {} | {:.3f} ({:.3f}) | {:.3f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} | {} |\n",
        name(run.kind), t.shots, percent(t.silent, t.shots), 100.0 * upper_limit_95(t.silent, t.shots),
        percent(t.unprovable, t.shots), percent(t.few, t.shots), percent(t.flagged, t.shots),
        percent(t.slides_wrongly, t.gripped), percent(t.grips_wrongly, t.slid), most_wrong(t),
        worst_shots(t.worst.empty() ? t.worst_unprovable : t.worst));
  return text;
}

std::string false_flags(const Row& undisturbed) {
  const Tally& t = undisturbed.tally;
  std::string text = fmt::format("false flags, {}:\n", name(undisturbed.run.kind));
  for (std::size_t i = 0; i < kFlagCount; ++i) {
    if (t.flags[i] == 0 || is_fact(kFlagNames[i])) continue;
    text += fmt::format("  {:<24} {:.3f} % (at most {:.3f} %)\n", kFlagNames[i], percent(t.flags[i], t.shots),
                        100.0 * upper_limit_95(t.flags[i], t.shots));
  }
  return text;
}

std::string coverage_table(const Row& row) {
  std::string text = fmt::format("coverage, {}:\n  {:<18} {:>8} {:>8} {:>8} {:>8}\n", name(row.run.kind), "",
                                 "numbers", "68.27 %", "95 %", "rms z");
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const Coverage& c = row.tally.coverage[i];
    text += fmt::format("  {:<18} {:>8} {:>8.2f} {:>8.2f} {:>8.3f}\n", kQuantityNames[i], c.count,
                        percent(c.within_68, c.count), percent(c.within_95, c.count), rms_z(c));
  }
  return text;
}

std::string json_line(const Row& row) {
  const Tally& t = row.tally;
  std::int64_t alarms = 0;  // of the most frequent one
  Json flags = Json::object(), quantities = Json::object(), worst = Json::array();
  for (std::size_t i = 0; i < kFlagCount; ++i) {
    if (t.flags[i] > 0) flags[std::string(kFlagNames[i])] = percent(t.flags[i], t.shots);
    if (!is_fact(kFlagNames[i])) alarms = std::max(alarms, t.flags[i]);
  }
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const Coverage& c = t.coverage[i];
    quantities[std::string(kQuantityNames[i])] = {{"silent", t.silent_by_quantity[i]},
                                                  {"numbers", c.count},
                                                  {"within_68_percent", percent(c.within_68, c.count)},
                                                  {"within_95_percent", percent(c.within_95, c.count)},
                                                  {"rms_z", rms_z(c)}};
  }
  for (const WorstShot& w : t.worst) worst.push_back({{"shot", w.number}, {"error_sd", w.error_sd}});
  const Json line{{"kind", name(row.run.kind)},
                  {"noise", row.run.settings.noise == NoiseLevel::hand ? "hand" : "digitizer"},
                  {"seed", row.run.seed},
                  {"shots", t.shots},
                  {"refused", t.refused},
                  {"silent", t.silent},
                  {"silent_percent", percent(t.silent, t.shots)},
                  {"silent_percent_limit_95", 100.0 * upper_limit_95(t.silent, t.shots)},
                  {"unprovable_percent", percent(t.unprovable, t.shots)},
                  {"wrong_and_few_images_percent", percent(t.few, t.shots)},
                  {"wrong_and_flagged_percent", percent(t.flagged, t.shots)},
                  {"slides_wrongly_percent", percent(t.slides_wrongly, t.gripped)},
                  {"grips_wrongly_percent", percent(t.grips_wrongly, t.slid)},
                  {"largest_alarm_percent", percent(alarms, t.shots)},
                  {"flags_percent", flags},
                  {"quantities", quantities},
                  {"worst", worst}};
  return line.dump() + "\n";
}

std::string shot_line(const Shot& shot) {
  Json line = Json::parse(messages::frame_to_json(shot.photograph.frame));
  Json truth = Json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i)
    truth[std::string(kQuantityNames[i])] = *shot.photograph.truth.value[static_cast<reduction::Quantity>(i)];
  truth["mirrored"] = shot.photograph.truth.mirrored;
  truth["regime"] = shot.photograph.truth.missing_mps < 1e-9 ? "grips" : "slides";
  line["truth"] = truth;
  line["trouble"] = {
      {"kind", name(shot.kind)}, {"severity", shot.severity}, {"provable", shot.proof_sd >= kProof_sd}};
  return line.dump() + "\n";
}

void Tally::add(const Shot& shot, std::uint64_t number) {
  ++shots;
  const auto readout = reduction::reduce(shot.photograph.frame, reduction::Estimator::best);
  if (!readout) {
    ++refused;
    return;
  }
  const Truth& truth = shot.photograph.truth;
  const Judgement j = judged(*readout, truth, shot.kind, shot.few);
  const bool provable = shot.proof_sd >= kProof_sd;
  if (j.silent.any()) {
    (provable ? silent : unprovable) += 1;
    keep_worst(provable ? worst : worst_unprovable, {number, j.worst});
  }
  few += j.silent.none() && j.few.any() ? 1 : 0;
  flagged += j.silent.none() && j.few.none() && j.flagged.any() ? 1 : 0;
  slides_wrongly += j.slides_wrongly ? 1 : 0;
  grips_wrongly += j.grips_wrongly ? 1 : 0;
  (truth.slid ? slid : gripped) += 1;
  for (std::size_t i = 0; i < kQuantityCount; ++i) silent_by_quantity[i] += j.silent.test(i) ? 1 : 0;
  for (std::size_t i = 0; i < kFlagCount; ++i)
    flags[i] += readout->flags.has(static_cast<reduction::Flag>(i)) ? 1 : 0;
  cover(*readout, truth, coverage);
}

void Tally::merge(const Tally& other) {
  shots += other.shots;
  refused += other.refused;
  silent += other.silent;
  unprovable += other.unprovable;
  few += other.few;
  flagged += other.flagged;
  slides_wrongly += other.slides_wrongly;
  grips_wrongly += other.grips_wrongly;
  gripped += other.gripped;
  slid += other.slid;
  for (std::size_t i = 0; i < kFlagCount; ++i) flags[i] += other.flags[i];
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    silent_by_quantity[i] += other.silent_by_quantity[i];
    coverage[i].count += other.coverage[i].count;
    coverage[i].within_68 += other.coverage[i].within_68;
    coverage[i].within_95 += other.coverage[i].within_95;
    coverage[i].square += other.coverage[i].square;
  }
  for (const WorstShot& w : other.worst) keep_worst(worst, w);
  for (const WorstShot& w : other.worst_unprovable) keep_worst(worst_unprovable, w);
}

double upper_limit_95(std::int64_t count, std::int64_t of) {
  if (of <= 0) return 1.0;
  const double n = static_cast<double>(of), p = static_cast<double>(count) / n;
  const double z2 = kOneSided95 * kOneSided95;
  return (p + 0.5 * z2 / n + kOneSided95 * std::sqrt(p * (1.0 - p) / n + 0.25 * z2 / (n * n))) /
         (1.0 + z2 / n);
}

Tally tallied(const Run& run) {
  Tally tally;
  for (std::int64_t i = 1; i <= run.shots; ++i) {
    const auto number = static_cast<std::uint64_t>(i);
    tally.add(drawn_shot(run.kind, run.settings, run.seed, number), number);
  }
  return tally;
}

}  // namespace strobe::contradictions
