#include "tests/contradictions/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/messages/json_conversions.hpp"
#include "tests/contradictions/proof.hpp"

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

}  // namespace strobe::contradictions
