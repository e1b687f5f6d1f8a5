// Whole simulated shots: what a model that leaves effects out saves, and what it changes in the readouts.
#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <optional>

#include "tests/studies/trade/studies.hpp"

#if STROBE_WITH_EFFECTS

#include "sim/effects/choice.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/studies/trade/stopwatch.hpp"

namespace strobe::studies::trade {

namespace {

constexpr sim::ShootSettings kPerfect{.perfect_digitizer = true};

/// A scene with the readouts of its shots by the full model.
struct Known {
  sim::Scene scene;
  bool thesis = false;
  sim::PerQuantity scale;
  std::vector<reduction::Quantities> full;
};

std::vector<reduction::Quantities> readouts(const sim::Scene& scene, const sim::Model& model, int shots,
                                            std::uint64_t seed) {
  std::vector<reduction::Quantities> all;
  auto shooter = sim::Shooter::make(scene, seed, model, kPerfect);
  for (int shot = 1; shooter && shot <= shots; ++shot)
    all.push_back(sim::readout_of(shooter->shoot(shot).frame));
  return all;
}

/// Largest difference of a shot's numbers, in their scales.
double difference(const reduction::Quantities& a, const reduction::Quantities& b,
                  const sim::PerQuantity& scale) {
  const sim::PerQuantity apart = sim::difference(a, b);
  double worst = 0.0;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) worst = std::max(worst, apart[i] / scale[i]);
  return worst;
}

bool of_the_thesis(const sim::Scene& scene) {
  for (const char* spin : {"zero_", "top_", "back_"})
    if (scene.name.rfind(spin, 0) == 0) return true;
  return false;
}

double cost_us(const sim::Scene& scene, const sim::Model& model, const Effort& effort) {
  auto shooter = sim::Shooter::make(scene, effort.seed, model, kPerfect);
  if (!shooter) return 0.0;
  constexpr int kShots = 10;
  return least_cost_us(effort.repetitions, kShots,
                       [&](std::size_t i) { keep(shooter->shoot(static_cast<int>(i) + 1)); });
}

}  // namespace

std::optional<Study> shot_study(const Effort& effort) {
  const auto scenes = sim::shipped_scene_files();
  if (!scenes) return std::nullopt;
  const int shots = effort.quick ? 5 : 100;
  std::vector<Known> known;
  std::deque<sim::ModelChooser> choosers;
  for (const sim::SceneFile& file : *scenes) {
    const sim::Scene& scene = file.scene.value();
    if (scene.camera.pixels || (effort.quick && known.size() == 2)) continue;
    choosers.emplace_back(scene);
    known.push_back({scene, of_the_thesis(scene), sim::readout_scales(scene),
                     readouts(scene, sim::Model::full(), shots, effort.seed)});
  }
  Study study{
      .name = "shot",
      .title = "Whole simulated shots, frame included",
      .what = fmt::format("{} shipped scenes without rendered pixels ({} of them the thesis's), {} shots "
                          "each, perfectly digitized; norm: the largest difference of a shot's numbers "
                          "from those of the full model in their scales; cost: mean over the scenes",
                          known.size(), std::ranges::count(known, true, &Known::thesis), shots),
      .unit = "of the readouts' scales"};
  std::vector<double> tolerances{0.0, 1e-4, 1e-3, 1e-2, 5e-2};
  if (effort.quick) tolerances = {0.0, 1e-2};
  for (const double tolerance : tolerances) {
    Row row{.method = tolerance > 0.0 ? "planned" : "full", .parameter = "", .source = Source::model};
    if (tolerance > 0.0) row.parameter = fmt::format("tolerance={}", tolerance);
    Tally thesis;
    Tally others;
    for (std::size_t i = 0; i < known.size(); ++i) {
      const Known& k = known[i];
      const sim::Model model = tolerance > 0.0 ? choosers[i].choose(tolerance).model : sim::Model::full();
      row.cost_us += cost_us(k.scene, model, effort) / static_cast<double>(known.size());
      const auto planned = readouts(k.scene, model, shots, effort.seed);
      for (std::size_t s = 0; s < planned.size(); ++s) {
        const double error = difference(planned[s], k.full[s], k.scale);
        others.add(error);
        if (k.thesis) thesis.add(error);
      }
    }
    row.practical = others.error();
    row.thesis = thesis.error();
    study.rows.push_back(row);
  }
  return study;
}

}  // namespace strobe::studies::trade

#else

namespace strobe::studies::trade {

std::optional<Study> shot_study(const Effort&) { return std::nullopt; }

}  // namespace strobe::studies::trade

#endif
