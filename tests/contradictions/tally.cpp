#include "tests/contradictions/tally.hpp"

#include <algorithm>
#include <cmath>

#include "common/reduction/uncertainty.hpp"
#include "common/reduction/reduce.hpp"
#include "tests/contradictions/proof.hpp"

namespace strobe::contradictions {
namespace {

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
    const auto sd = combined_sd(readout, q);
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

Tally tallied(const Run& run, const std::function<void(std::int64_t)>& progress) {
  Tally tally;
  for (std::int64_t i = 1; i <= run.shots; ++i) {
    const auto number = static_cast<std::uint64_t>(i);
    tally.add(drawn_shot(run.kind, run.settings, run.seed, number), number);
    if (progress && i % 100 == 0) progress(i);
  }
  return tally;
}

}  // namespace strobe::contradictions
