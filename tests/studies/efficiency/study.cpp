#include "tests/studies/efficiency/study.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "common/reduction/uncertainty.hpp"
#include "tests/studies/in_parallel.hpp"

namespace strobe::studies {

namespace {

using namespace reduction;

constexpr int kPhases = 50;
constexpr double kDegree = std::numbers::pi / 180.0;

/// The sums that a score is made of.
class Errors {
 public:
  void add(double error, double bound, std::optional<double> sd, std::optional<double> expanded) {
    ++count_;
    square_ += error * error;
    const double relative = error / bound;
    bias_ += relative;
    by_bound_ += relative * relative;
    sizes_.push_back(std::abs(relative));
    if (!sd) return;
    const double normalized = error / *sd;
    ++stated_;
    by_sd_ += normalized * normalized;
    within_68_ += std::abs(normalized) < 1.0 ? 1 : 0;
    within_95_ += std::abs(error) < *expanded ? 1 : 0;
  }
  void add_absent() { ++absent_; }

  Score score() {
    constexpr double kNormalMedian = 0.6744897501960817;
    Score s{.shots = count_ + absent_, .absent = absent_};
    if (count_ == 0) return s;
    const double n = count_;
    s.rms = std::sqrt(square_ / n);
    s.bias = bias_ / n;
    s.by_bound = std::sqrt(by_bound_ / n);
    const auto middle = sizes_.begin() + count_ / 2;
    std::nth_element(sizes_.begin(), middle, sizes_.end());
    s.typical = *middle / kNormalMedian;
    if (stated_ == 0) return s;
    s.by_sd = std::sqrt(by_sd_ / stated_);
    s.within_68 = within_68_ / static_cast<double>(stated_);
    s.within_95 = within_95_ / static_cast<double>(stated_);
    return s;
  }

 private:
  int count_ = 0, absent_ = 0, stated_ = 0, within_68_ = 0, within_95_ = 0;
  double square_ = 0.0, bias_ = 0.0, by_bound_ = 0.0, by_sd_ = 0.0;
  std::vector<double> sizes_;
};

using AllErrors = std::vector<std::array<Errors, kQuantityCount>>;

void reduce_one(const reduction::Frame& frame, const std::vector<Method>& methods, const Quantities& truth,
                const Quantities& bound, AllErrors& errors) {
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const auto readout = reduction::reduce(frame, methods[m].estimator, methods[m].options);
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      if (!truth[q]) continue;
      if (readout && readout->value[q]) {
        errors[m][i].add(*readout->value[q] - *truth[q], *bound[q], readout->sd[q],
                         reduction::expanded_uncertainty(*readout, q));
      } else {
        errors[m][i].add_absent();
      }
    }
  }
}

/// FNV-1a: the same everywhere, so that a condition's shots do not depend on which others are run.
std::uint32_t checksum(const std::string& text) {
  std::uint32_t hash = 2166136261U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

test::Setup setup_of(const Scenario& scenario) {
  test::Setup setup;
  setup.incoming = setup.rebound = scenario.images;
  setup.state_noise = scenario.noise_stated;
  setup.late_before_td_s = scenario.late_s;
  return setup;
}

Condition run_one(const Plan& plan, const Scenario& scenario, std::size_t index) {
  const test::Bounce& bounce = plan.bounces[index];
  std::seed_seq words{static_cast<std::uint32_t>(plan.seed), static_cast<std::uint32_t>(plan.seed >> 32U),
                      checksum(scenario.name), checksum(bounce.label)};
  test::Random random(words);
  const Quantities truth = test::truth(bounce);
  AllErrors errors(plan.methods.size());
  test::Setup setup = setup_of(scenario);
  for (int phase = 0; phase < kPhases; ++phase) {
    setup.phase = (phase + 0.5) / kPhases;
    setup.roll_rad = std::uniform_real_distribution<double>(-1.0, 1.0)(random) * scenario.tilt_rad;
    const Quantities bound = test::cramer_rao(bounce, setup);
    const int shots = plan.shots * (phase + 1) / kPhases - plan.shots * phase / kPhases;
    for (int shot = 0; shot < shots; ++shot)
      reduce_one(test::photograph(bounce, setup, random), plan.methods, truth, bound, errors);
  }
  Condition condition{.name = bounce.label, .of_method = {}};
  for (auto& method : errors) {
    Scores& scores = condition.of_method.emplace_back();
    for (std::size_t i = 0; i < kQuantityCount; ++i) scores[i] = method[i].score();
  }
  return condition;
}

}  // namespace

std::vector<Method> all_methods() {
  return {{.name = "best", .estimator = Estimator::best, .options = {}},
          {.name = "best, no air",
           .estimator = Estimator::best,
           .options = {.effects = flight::kGravityOnly, .covariance = false}},
          {.name = "best, no air, no gravity",
           .estimator = Estimator::best,
           .options = {.effects = flight::kNoEffects, .covariance = false}},
          {.name = "two-point", .estimator = Estimator::two_point, .options = {}},
          {.name = "legacy", .estimator = Estimator::legacy, .options = {}}};
}

std::vector<Scenario> all_scenarios() {
  std::vector<Scenario> scenarios;
  for (const int images : {3, 5}) {
    const std::string n = std::to_string(images);
    const Scenario tilted{.name = "stated-" + n,
                          .what = n + " images a leg, noise stated, camera level within ±1 degree",
                          .images = images,
                          .tilt_rad = kDegree};
    Scenario estimated = tilted;
    estimated.name = "estimated-" + n;
    estimated.what = n + " images a leg, noise estimated from the shot, camera level within ±1 degree";
    estimated.noise_stated = false;
    Scenario level = tilted;
    level.name = "level-" + n;
    level.what = n + " images a leg, noise stated, camera exactly level";
    level.tilt_rad = 0.0;
    Scenario late = level;
    late.name = "late-" + n;
    late.what =
        n + " images a leg, noise stated, camera exactly level, last flash before touchdown 160 us late";
    late.late_s = 160e-6;
    for (const Scenario& s : {tilted, estimated, level, late}) scenarios.push_back(s);
  }
  return scenarios;
}

std::vector<Condition> run(const Plan& plan, const Scenario& scenario, std::atomic<int>& done) {
  std::vector<Condition> conditions(plan.bounces.size());
  in_parallel(conditions.size(), static_cast<unsigned>(plan.threads), [&](std::size_t i) {
    conditions[i] = run_one(plan, scenario, i);
    ++done;
  });
  return conditions;
}

}  // namespace strobe::studies
