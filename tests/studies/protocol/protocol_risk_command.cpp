// strobe-bench protocol-risk: whole tests by a protocol on simulated surfaces and balls whose true result is known. How
// often is a verdict wrong, at a limit and where the truth may be anywhere, and what risk was stated?
//
// A laboratory's errors (scale, balls' sizes, drag, thermometer) are drawn for each test, and each ball is another one:
// restitution and friction differ from ball to ball as well as from shot to shot.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "common/reduction/mixture.hpp"
#include "common/reduction/reduce.hpp"
#include "host/config/rig_file.hpp"
#include "host/protocol/evaluation.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/studies/in_parallel.hpp"

namespace {

using namespace strobe;
using protocol::Outcome;
using reduction::Quantity;

constexpr double kGravity_mps2 = 9.80665, kAirDensity_kgpm3 = 1.204;
constexpr double kScaleSd = 0.001, kDiameterSd_m = 0.0002, kDragCoefficientSd = 0.05, kThermometerSd_K = 0.5;
constexpr double kBallESd = 0.004, kBallMuSd = 0.006;  ///< from ball to ball

/// Of a ball in a scene's air.
double drag_per_m(const sim::Scene& scene) {
  return kAirDensity_kgpm3 * 293.15 / (273.15 + scene.air.temperature_c) * scene.air.drag_coefficient *
         std::acos(-1.0) * std::pow(scene.ball.diameter_m, 2) / (8.0 * scene.ball.mass_kg);
}

/// The heights that the scene's ball rises to in cm when it is dropped from 254 cm: see the equations of motion's first
/// integrals, dv/dt = -g -+ k v^2.
double rebound_cm(double e, const sim::Scene& scene) {
  const double k = drag_per_m(scene), g = kGravity_mps2;
  const double landing_squared = g / k * (1.0 - std::exp(-2.0 * k * 2.54));
  return 100.0 * std::log(1.0 + k * e * e * landing_squared / g) / (2.0 * k);
}

double court_pace(double e, double mu, double temperature_c) {
  return 100.0 * (1.0 - mu) + 150.0 * (0.81 - (e + 0.003 * (23.0 - temperature_c)));
}

/// What is tested, and what is turned to have another truth.
struct Case {
  const char* protocol;
  const char* scene;
  Duration period;
  double sim::BounceSettings::*turned;
  double least, most;  ///< of it
  double limit;        ///< of the result
  double reach;        ///< truths are drawn so far on either side of it
  bool ball_is_tested;  ///< else balls are a sample, each another one
  std::function<double(double e, double mu, const sim::Scene&)> result;
};

const std::array<Case, 2> kCases{{{"itf-court-pace", "itf_pace_medium", milliseconds(3), &sim::BounceSettings::mu, 0.52, 0.74,
                                   34.5, 6.0, false,
                                   [](double e, double mu, const sim::Scene& s) { return court_pace(e, mu, s.air.temperature_c); }},
                                  {"itf-ball-rebound", "drop_100in", milliseconds(10), &sim::BounceSettings::e, 0.70, 0.82, 135.0,
                                   10.0, true, [](double e, double, const sim::Scene& s) { return rebound_cm(e, s); }}}};

/// Means of endless shots, by what is turned: between some values, linearly.
class Truth {
 public:
  Truth(const Case& of, const sim::Scene& scene, int shots) : case_(of) {
    for (int i = 0; i < kPoints; ++i) {
      sim::Scene turned = scene;
      turned.bounce.*of.turned = turned_at(i);
      auto shooter = sim::Shooter::make(turned, 77);
      for (int shot = 1; shot <= shots; ++shot) {
        const reduction::Quantities truth = shooter->shoot(shot).truth;
        e_[i] += *truth[Quantity::e] / shots;
        mu_[i] += *truth[Quantity::mu] / shots;
      }
    }
  }

  /// What has to be turned to so that the scene's result is that.
  double turned_for(double result, const sim::Scene& scene) const {
    double low = case_.least, high = case_.most;
    const bool rising = of(high, scene) > of(low, scene);
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      ((of(middle, scene) < result) == rising ? low : high) = middle;
    }
    return low;
  }

 private:
  static constexpr int kPoints = 12;
  double turned_at(int i) const { return case_.least + (case_.most - case_.least) * i / (kPoints - 1); }
  double of(double turned, const sim::Scene& scene) const {
    const double place = (turned - case_.least) / (case_.most - case_.least) * (kPoints - 1);
    const int i = std::min(kPoints - 2, static_cast<int>(place));
    const double share = place - i;
    return case_.result(e_[i] + share * (e_[i + 1] - e_[i]), mu_[i] + share * (mu_[i + 1] - mu_[i]), scene);
  }

  const Case& case_;
  std::array<double, kPoints> e_{}, mu_{};
};

/// One test from the first shot to the verdict.
class Laboratory {
 public:
  Laboratory(const Case& of, const sim::Scene& nominal, std::uint64_t seed) : case_(of), stated_(nominal), random_(seed) {
    scene = nominal;
    scale_ = 1.0 + kScaleSd * normal_(random_);
    scene.air.drag_coefficient += kDragCoefficientSd * normal_(random_);
    scene.air.spin_decay_per_m *= std::max(0.0, 1.0 + 0.5 * normal_(random_));
    if (of.ball_is_tested) scene.ball.diameter_m += kDiameterSd_m * normal_(random_);
    thermometer_K_ = kThermometerSd_K * normal_(random_);
    auto rig = std::make_shared<host::RigFile>();
    rig->ball.diameter_m = nominal.ball.diameter_m;
    rig->ball.mass_kg = nominal.ball.mass_kg;
    rig_ = rig;
  }

  sim::Scene scene;  ///< the true one; its surface is turned from outside

  std::vector<host::Shot> test(const protocol::Protocol& protocol) {
    std::vector<host::Shot> shots;
    for (int blocks = 0; blocks < 100; ++blocks) {
      const protocol::Evaluation e = protocol::evaluate(protocol, 1, shots);
      if (e.blocks.empty() || e.out_of_replacements) break;
      for (int i = 0; i < e.blocks[0].shots; ++i) shots.push_back(shoot(e.blocks[0].cell, static_cast<int>(shots.size()) + 1));
    }
    return shots;
  }

 private:
  struct Ball {
    std::string name;
    double diameter_m;
    sim::Shooter shooter;
    int shots = 0;
  };

  Ball& ball(const std::string& name) {
    for (const auto& ball : balls_)
      if (ball->name == name) return *ball;
    sim::Scene its = scene;
    if (!case_.ball_is_tested) {
      its.ball.diameter_m += kDiameterSd_m * normal_(random_);
      its.bounce.e += kBallESd * normal_(random_);
      its.bounce.mu += kBallMuSd * normal_(random_);
    }
    auto shooter = sim::Shooter::make(its, random_(), sim::Model::full(), {.period = case_.period});
    balls_.push_back(std::make_unique<Ball>(Ball{name, its.ball.diameter_m, std::move(*shooter)}));
    return *balls_.back();
  }

  host::Shot shoot(const protocol::Cell& cell, int number) {
    Ball& its = ball(cell.ball);
    reduction::Frame frame = its.shooter.shoot(++its.shots).frame;
    frame.ball_diameter_m = stated_.ball.diameter_m;
    frame.ball_diameter_sd_m = kDiameterSd_m;
    frame.px_per_m = stated_.camera.px_per_m * scale_;
    frame.px_per_m_sd = stated_.camera.px_per_m * kScaleSd;
    frame.temperature_c = stated_.air.temperature_c + thermometer_K_;
    host::Shot shot;
    shot.name = std::to_string(number);
    shot.ball = its.name;
    shot.rig = rig_;
    const auto readout = reduction::reduce(frame, reduction::Estimator::best);
    if (readout) shot.readout = *readout;
    shot.rejected = readout ? host::rejection_reason(*readout) : std::optional(readout.error().message);
    if (!shot.rejected) shot.budget = reduction::mixture_budget(frame, shot.readout);
    shot.readout.record = {{std::string(protocol::kPositionNote), cell.position},
                           {std::string(protocol::kBallNote), cell.ball},
                           {"temperature_c", fmt::format("{}", *frame.temperature_c)}};
    return shot;
  }

  const Case& case_;
  const sim::Scene& stated_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  double scale_ = 1.0, thermometer_K_ = 0.0;
  std::shared_ptr<const host::RigFile> rig_;
  std::vector<std::unique_ptr<Ball>> balls_;
};

/// Of the last requirement, which is the one about the result.
struct Statement {
  Outcome outcome = Outcome::incomplete;
  std::optional<double> risk;
  protocol::Interval said;  ///< that the result is within, or of a fail that it is not
};

Statement statement_of(const protocol::Protocol& protocol, const std::vector<host::Shot>& shots) {
  const protocol::Evaluation e = protocol::evaluate(protocol, 1, shots);
  const protocol::Verdict& v = e.verdicts.back();
  const protocol::Requirement& r = protocol.requirements.back();
  Statement s{v.outcome, v.risk, r.limits};
  for (const protocol::Category& c : r.categories)
    if (c.name == v.category) s.said = c.range;
  return s;
}

bool is_decided(const Statement& s) { return s.outcome == Outcome::pass || s.outcome == Outcome::fail; }
bool is_wrong(const Statement& s, double truth) {
  return is_decided(s) && (truth >= s.said.low && truth <= s.said.high) != (s.outcome == Outcome::pass);
}

struct Count {
  int tests = 0, incomplete = 0, decided = 0, wrong = 0;
  double stated_risk = 0.0;

  void add(const Statement& s, double truth) {
    ++tests;
    if (s.outcome == Outcome::incomplete || s.outcome == Outcome::withheld) ++incomplete;
    if (!is_decided(s)) return;
    ++decided;
    if (is_wrong(s, truth)) ++wrong;
    stated_risk += *s.risk;
  }
  void add(const Count& o) {
    tests += o.tests;
    incomplete += o.incomplete;
    decided += o.decided;
    wrong += o.wrong;
    stated_risk += o.stated_risk;
  }
};

struct Counts {
  Count above, below, anywhere, anywhere_simple;  ///< above: with a truth just above the limit
  void add(const Counts& o) {
    above.add(o.above);
    below.add(o.below);
    anywhere.add(o.anywhere);
    anywhere_simple.add(o.anywhere_simple);
  }
};

struct Options {
  int runs = 400, threads = 2, truth_shots = 2000;
  std::uint64_t seed = 1;
  std::string only;
};

Counts run_of(const Case& of, const sim::Scene& scene, const Truth& truth, const protocol::Protocol& protocol,
              std::uint64_t seed) {
  protocol::Protocol simple = protocol;
  simple.requirements.back().rule = protocol::DecisionRule::simple;
  std::mt19937_64 random(seed);
  const double drawn = of.limit + of.reach * std::uniform_real_distribution<double>(-1.0, 1.0)(random);
  Counts counts;
  for (const double result : {of.limit, drawn}) {
    Laboratory laboratory(of, scene, random());
    laboratory.scene.bounce.*of.turned = truth.turned_for(result, laboratory.scene);
    const auto shots = laboratory.test(protocol);
    const Statement statement = statement_of(protocol, shots);
    if (result == drawn) {
      counts.anywhere.add(statement, result);
      counts.anywhere_simple.add(statement_of(simple, shots), result);
    } else {
      counts.above.add(statement, result + 1e-6);
      counts.below.add(statement, result - 1e-6);
    }
  }
  return counts;
}

void report(const char* protocol, const char* what, const Count& c) {
  const double n = c.tests, wrong = c.wrong / n;
  fmt::print("{:<18} {:<34} {:>5} tests {:>4} incomplete {:>5.1f} % decided {:>5.2f} ± {:.2f} % wrong, stated {:.2f} %\n", protocol,
             what, c.tests, c.incomplete, 100.0 * c.decided / n, 100.0 * wrong,
             100.0 * std::sqrt(std::max(wrong, 1.0 / n) / n), 100.0 * c.stated_risk / n);
}

int protocol_risk(const Options& options) {
  for (const Case& of : kCases) {
    if (!options.only.empty() && options.only != of.protocol) continue;
    const auto protocol = protocol::load_protocol(of.protocol);
    auto scene = sim::load_scene(of.scene);
    if (!protocol || !scene) {
      fmt::print(stderr, "strobe-bench: {}\n", protocol ? scene.error().message : protocol.error().message);
      return 2;
    }
    // As the digitizer measures photographs, not as a hand does.
    scene->tablet.centre_sd_m = 2e-5;
    scene->tablet.equator_sd_rad = 2e-3;
    const Truth truth(of, *scene, options.truth_shots);
    std::vector<Counts> each(static_cast<std::size_t>(options.runs));
    studies::in_parallel(each.size(), static_cast<unsigned>(options.threads), [&](std::size_t i) {
      each[i] = run_of(of, *scene, truth, *protocol, options.seed * 1'000'003 + i);
    });
    Counts all;
    for (const Counts& one : each) all.add(one);
    report(of.protocol, "truth just above the limit", all.above);
    report(of.protocol, "truth just below the limit", all.below);
    report(of.protocol, "truth anywhere about it, guarded", all.anywhere);
    report(of.protocol, "truth anywhere about it, simple", all.anywhere_simple);
  }
  return 0;
}

}  // namespace

namespace strobe::studies {

void add_protocol_risk_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("protocol-risk", "How often verdicts of test protocols are wrong, and the risk stated");
  command->add_option("--runs", options->runs, "tests at the limit, and as many elsewhere")->check(CLI::Range(1, 1000000))->capture_default_str();
  command->add_option("--protocol", options->only, "only this one: itf-court-pace, itf-ball-rebound");
  command->add_option("--truth-shots", options->truth_shots, "for each point of the truth")->check(CLI::Range(10, 1000000))->capture_default_str();
  command->add_option("--seed", options->seed, "repeats a run, with any number of threads")->capture_default_str();
  command->add_option("--threads", options->threads, "run in parallel")->check(CLI::Range(1, 256))->capture_default_str();
  command->footer("Example: strobe-bench protocol-risk --runs 400");
  command->callback([options, &exit_status] { exit_status = protocol_risk(*options); });
}

}  // namespace strobe::studies
