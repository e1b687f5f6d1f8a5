// strobe-bench attitude: attitudes by a pattern of dots against the truth of rendered balls; with --spindoe, on the crops of
// a flying table-tennis ball that SpinDOE (Gossard, Tebbe, Ziegler and Zell, IROS 2023, arXiv 2303.03879) publishes. Its
// abstract states a mean orientation error of 2.4 degrees and a relative error of the spin below 1 % at 350 frames/s; how
// these were judged could not be read. Crops have no truth: what is told of them is how well attitudes agree with one
// motion, and how well those of all other images foretell each.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "common/attitude/attitude_spin.hpp"
#include "common/config/files.hpp"
#include "host/digitize/pattern/dot_pattern.hpp"
#include "tests/benchmarks/command.hpp"
#include "tests/host/digitize/dotted_ball.hpp"

namespace strobe::studies {
namespace {

namespace fs = std::filesystem;
using attitude::SpinFit;
using attitude::SpinSearch;
using attitude::TimedAttitude;
using digitize::DotPattern;

constexpr double kDegree = std::numbers::pi / 180.0;
// Half of 350 turns a second, SpinDOE's own limit, is 1100 rad/s.
constexpr double kFastest_radps = 1100.0;

struct Options {
  int balls = 100;
  std::string spindoe;
  double pattern_sd_deg = 1.0;
};

struct Tally {
  int found = 0, none = 0, wrong = 0;
  double squares = 0.0, standardized = 0.0;
};

/// Uniform attitudes, lamps and sub-pixel places; the pattern as exact as it is drawn.
Tally rendered(double diameter_px, double noise, double smear_px, int balls) {
  constexpr double kWrong_rad = 0.17;
  const DotPattern pattern{testing::drawn_pattern(20, 0.45, 4)};
  std::mt19937_64 random(static_cast<std::uint64_t>(diameter_px));
  std::uniform_real_distribution<double> share;
  Tally tally;
  for (int k = 0; k < balls; ++k) {
    testing::DottedBall ball{.dots = pattern.dots, .diameter_px = diameter_px, .smear_px = smear_px, .noise = noise};
    ball.attitude = testing::attitude_from(share(random), share(random), share(random));
    ball.off_px = {share(random), share(random)};
    ball.lamp = {2.0 * share(random) - 1.0, 2.0 * share(random) - 1.0, 1.0};
    ball.seed = static_cast<std::uint64_t>(k);
    const auto photograph = testing::photograph_of(ball);
    const auto outline = digitize::only_ball(photograph);
    if (!outline) {
      ++tally.none;
      continue;
    }
    const auto found = digitize::measure_attitude(photograph, digitize::PlaneMap::uncalibrated(photograph.height()),
                                                  *outline, pattern, 1e-3);
    if (!found) {
      ++tally.none;
      continue;
    }
    const Eigen::Vector3d error = attitude::rotation_vector_rad(found->attitude * ball.attitude.transpose());
    if (error.norm() > kWrong_rad) {
      ++tally.wrong;
      continue;
    }
    ++tally.found;
    tally.squares += error.squaredNorm();
    tally.standardized += error.dot(found->covariance_rad2.inverse() * error) / 3.0;
  }
  return tally;
}

void judge_rendered(int balls) {
  fmt::print("rendered balls, {} each, 20 dots: attitude's error (angle of the rotation), and over its sd\n", balls);
  fmt::print("{:>8} {:>8} {:>8} {:>8} {:>6} {:>7} {:>9} {:>9}\n", "px", "noise", "smear px", "found", "none", "wrong",
             "rms deg", "over sd");
  struct Case {
    double diameter_px, noise, smear_px;
  };
  for (const auto& [px, noise, smear] : std::array<Case, 6>{{{60, 0.01, 0}, {60, 0.03, 3}, {100, 0.01, 0}, {100, 0.03, 4}, {150, 0.01, 0}, {200, 0.01, 0}}}) {
    const Tally t = rendered(px, noise, smear, balls);
    const double n = std::max(1, t.found);
    fmt::print("{:>8} {:>8} {:>8} {:>8} {:>6} {:>7} {:>9.3f} {:>9.2f}\n", px, noise, smear, t.found, t.none, t.wrong,
               std::sqrt(t.squares / n) / kDegree, std::sqrt(t.standardized / n));
  }
}

double rms_deg(const std::vector<Eigen::Vector3d>& residuals, const std::vector<bool>& used) {
  double sum = 0.0, n = 0.0;
  for (std::size_t k = 0; k < residuals.size(); ++k)
    if (used[k]) sum += residuals[k].squaredNorm(), n += 1.0;
  return std::sqrt(sum / n) / kDegree;
}

/// Each attitude foretold from all others.
void leave_one_out(const std::vector<TimedAttitude>& all, const SpinSearch& search) {
  double sum = 0.0, mean = 0.0, worst = 0.0;
  std::vector<double> rates;
  for (std::size_t k = 0; k < all.size(); ++k) {
    auto others = all;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const auto fits = attitude::fit_spin(others, search);
    if (!fits) continue;
    const double off = attitude::rotation_vector_rad(all[k].attitude * fits->front().attitude_at(all[k].time_s).transpose()).norm() / kDegree;
    sum += off * off, mean += off, worst = std::max(worst, off);
    rates.push_back(fits->front().spin_radps.norm());
  }
  const auto n = static_cast<double>(all.size());
  const auto [least, most] = std::ranges::minmax(rates);
  fmt::print("  each from the others: {:.2f} deg rms, {:.2f} mean, {:.2f} at most; rates from {:.2f} to {:.2f} rad/s\n",
             std::sqrt(sum / n), mean / n, worst, least, most);
}

void judge_motion(const char* what, const std::vector<TimedAttitude>& attitudes, const SpinSearch& search) {
  const auto fits = attitude::fit_spin(attitudes, search);
  if (!fits) {
    fmt::print("{}: {}\n", what, fits.error().message);
    return;
  }
  const SpinFit& fit = fits->front();
  const double rate = fit.spin_radps.norm();
  const Eigen::Vector3d axis = fit.spin_radps / rate;
  const double sd = std::sqrt(axis.dot(fit.covariance_radps2 * axis));
  fmt::print("{}: {} of {} used, {:.2f} deg rms, chi squared {:.1f} for {}; {} as good\n", what,
             std::ranges::count(fit.used, true), attitudes.size(), rms_deg(fit.residuals_rad, fit.used), fit.chi_squared,
             fit.degrees_of_freedom, fits->size() - 1);
  fmt::print("  spin {:.2f} ± {:.2f} rad/s ({:.3f} %), axis ± {:.2f} deg\n", rate, sd, 100.0 * sd / rate,
             std::sqrt(std::max(0.0, fit.covariance_radps2.trace() - sd * sd)) / rate / kDegree);
  if (search.wobble_sd > 0.0)
    fmt::print("  decay {:.3f} ± {:.3f} per s, wobble {:.2f} ± {:.2f} rad/s\n", fit.decay_per_s, fit.decay_sd_per_s,
               fit.wobble_radps.norm(), std::sqrt(fit.wobble_covariance_radps2.trace() / 2.0));
  leave_one_out(attitudes, search);
}

int judge_spindoe(const Options& options) {
  const fs::path folder = options.spindoe;
  const auto text = config::read_file((folder / "ref_pattern.csv").string());
  const auto pattern = text ? digitize::parse_dot_pattern(*text, "ref_pattern.csv") : tl::unexpected(text.error());
  std::error_code error;
  if (!pattern || !fs::is_directory(folder / "test", error)) {
    fmt::print(stderr, "strobe-bench: attitude: {}: must hold ref_pattern.csv and test/*.png\n", options.spindoe);
    return 2;
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder / "test"))
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<TimedAttitude> attitudes;
  double squares = 0.0;
  for (const fs::path& file : files) {
    const auto photograph = digitize::load_photograph(file);
    if (!photograph) continue;
    const auto outline = digitize::only_ball(*photograph);
    if (!outline) continue;
    const auto found = digitize::measure_attitude(*photograph, digitize::PlaneMap::uncalibrated(photograph->height()), *outline,
                                                  *pattern, options.pattern_sd_deg * kDegree);
    if (!found) {
      fmt::print("{}: {}\n", file.filename().string(), found.error().message.substr(found.error().message.rfind(": ") + 2));
      continue;
    }
    squares += found->rms_rad * found->rms_rad;
    attitudes.push_back({std::stod(file.stem().string()) * 1e-9, found->attitude, found->covariance_rad2});
  }
  if (attitudes.size() < 3) return 1;
  const auto n = static_cast<double>(attitudes.size());
  double stated = 0.0;
  for (const TimedAttitude& one : attitudes) stated += one.covariance_rad2.trace() / n;
  fmt::print("SpinDOE's crops: {} of {} attitudes; dots {:.2f} deg rms from the pattern, attitudes to {:.2f} deg as stated\n",
             attitudes.size(), files.size(), std::sqrt(squares / n) / kDegree, std::sqrt(stated) / kDegree);
  judge_motion("constant spin", attitudes, {.fastest_spin_radps = kFastest_radps});
  judge_motion("with decay and wobble", attitudes, {.fastest_spin_radps = kFastest_radps, .decay_sd_per_s = 0.5, .wobble_sd = 0.01});
  fmt::print("SpinDOE states: 2.4 deg mean error of an attitude, spin to 1 %\n");
  return 0;
}

}  // namespace

void add_attitude_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "attitude",
      "attitudes of balls with a pattern of dots: rendered ones against the truth, and published crops.\n"
      "Example: strobe-bench attitude --balls 20");
  command->add_option("--balls", options->balls, "rendered balls of each size")->check(CLI::Range(1, 100000))->capture_default_str();
  command->add_option("--spindoe", options->spindoe, "judge by SpinDOE's crops instead: a folder with ref_pattern.csv and test/*.png");
  command->add_option("--pattern-sd-deg", options->pattern_sd_deg, "how well its dots are where the pattern says")
      ->check(CLI::Range(0.01, 10.0))->capture_default_str();
  command->callback([options, &exit_status] {
    exit_status = 0;
    if (options->spindoe.empty())
      judge_rendered(options->balls);
    else
      exit_status = judge_spindoe(*options);
  });
}

}  // namespace strobe::studies
