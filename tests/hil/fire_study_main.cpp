// strobe-fire-study: shots fired at scenes through the shipped programs, photographs and all, with the default train
// and with an even one: how many come, why others are rejected, which images are called outliers, and how far the
// numbers are from the truth. By hand, on an idle machine: in real time, some three seconds a shot.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "sim/loading/load_scene.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/truth_score.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe;
using namespace strobe::hil;
namespace fs = std::filesystem;

namespace {

constexpr int kDone = 0, kFailed = 1;

struct Plan {
  std::vector<std::string> scenes{"itf_pace_medium", "zero_23", "back_35", "top_71", "top_18"};
  std::vector<std::string> trains{"default", "even"};
  int shots = 200, batch = 20;
  std::uint64_t seed = 1;
  std::string effort = "standard", keep;
  std::optional<double> flash_time_sd_us;
};

/// Those that a session is fired for.
const std::vector<std::string> kEssential{"vx_td_mps", "vy_td_mps", "omega_td_radps",
                                          "vx_lo_mps", "vy_lo_mps", "omega_lo_radps",
                                          "e",         "mu",        "dwell_time_ms"};

/// What became of the shots of one scene with one train.
struct Tally {
  int asked = 0, fired = 0, came = 0, ambiguous = 0, outliers = 0, named = 0, misnamed = 0;
  std::map<std::string, int> rejected, flags;
  TruthScore score;
  std::string trouble;
};

/// By shot: why it did not count, as strobe fire says on standard error; without figures, so that they can be counted.
std::map<int, std::string> rejections(const std::string& err) {
  static const std::regex line("shot (\\d+) is rejected \\((.*)\\)(: firing again| and no retries)");
  static const std::regex largest(" \\([a-z_]+ by [^)]*\\)"), figures("[0-9.]+");
  std::map<int, std::string> found;
  for (std::sregex_iterator it(err.begin(), err.end(), line), end; it != end; ++it) {
    const std::string why = std::regex_replace((*it)[2].str(), largest, "");
    found[std::stoi((*it)[1])] = std::regex_replace(why, figures, "N");
  }
  return found;
}

const nlohmann::json* truth_of(const std::vector<nlohmann::json>& truths, const nlohmann::json& readout) {
  for (const auto& truth : truths)
    if (truth.at("shot_id") == readout.at("shot_id")) return &truth;
  return nullptr;
}

bool shows(const nlohmann::json& truth, const nlohmann::json& flash) {
  for (const auto& image : truth.at("images"))
    if (image.at("flash_index") == flash) return true;
  return false;
}

void count(const nlohmann::json& readout, const nlohmann::json* truth, const std::string& name,
           Tally& tally) {
  for (const auto& flag : readout.at("flags")) ++tally.flags[flag.get<std::string>()];
  if (has_flag(readout, "outlier_image")) ++tally.outliers;
  const auto& misassignment = readout.at("misassignment_probability");
  if (truth == nullptr || misassignment.is_null()) return;
  if (misassignment.get<double>() < 0.01) {
    ++tally.named;
    if (!shows(*truth, readout.at("first_flash")) || !shows(*truth, readout.at("last_flash")))
      ++tally.misnamed;
  }
  tally.score.add(readout, *truth, name);
}

/// Whether there is something to look at; few images are none's fault.
bool is_conspicuous(const nlohmann::json& readout) {
  return std::ranges::any_of(readout.at("flags"),
                             [](const nlohmann::json& flag) { return flag != "no_redundancy"; });
}

/// Readouts, truth, logs and the photographs of shots rejected or flagged.
void keep(const RigFixture& bench, const testing::CompletedProcess& fired, const fs::path& folder) {
  fs::create_directories(folder);
  testing::write_text(folder / "readouts.jsonl", fired.out);
  testing::write_text(folder / "fire.err", fired.err);
  fs::copy_file(bench.folder() / "truth.jsonl", folder / "truth.jsonl", fs::copy_options::overwrite_existing);
  const auto lost = rejections(fired.err);
  for (const auto& entry : fs::directory_iterator(bench.session())) {
    if (entry.is_regular_file())
      fs::copy_file(entry.path(), folder / entry.path().filename(), fs::copy_options::overwrite_existing);
  }
  for (const auto& readout : readouts(fired.out)) {
    const int shot = readout.at("shot_id").get<int>();
    if (!lost.contains(shot) && !is_conspicuous(readout)) continue;
    const std::regex of_shot(fmt::format("(.*[^0-9])?0*{}[^0-9].*", shot));
    for (const auto& entry : fs::directory_iterator(bench.session() / "photographs")) {
      const fs::path name = entry.path().filename();
      if (std::regex_match(name.string(), of_shot))
        fs::copy_file(entry.path(), folder / name, fs::copy_options::overwrite_existing);
    }
  }
}

/// The rig as shipped, but for what an operator would tell of the scene: the ball's diameter and the temperature.
RigFixtureOptions bench_options(const Plan& plan, const std::string& scene, std::uint64_t seed,
                                const fs::path& camera) {
  RigFixtureOptions options;
  options.scene = scene;
  options.seed = seed;
  const sim::Scene thrown = sim::load_scene(share("scenes") / (scene + ".toml")).value();
  options.rig_edits = {
      {"\ndiameter_m = 0.0651\n", fmt::format("\ndiameter_m = {}\n", thrown.ball.diameter_m)},
      {"temperature_c = 21.0", fmt::format("temperature_c = {}", thrown.air.temperature_c)},
      // The simulated camera takes longer than a real one to write a photograph.
      {"photograph_timeout_s = 5", "photograph_timeout_s = 120"}};
  if (plan.flash_time_sd_us)
    options.rig_edits.emplace_back("#flash_time_sd_us = 2.0",
                                   fmt::format("flash_time_sd_us = {}", *plan.flash_time_sd_us));
  options.sim_options = {"--photographs", camera};
  return options;
}

void fire_batch(const Plan& plan, const std::string& scene, const std::string& train, std::uint64_t seed,
                int shots, Tally& tally) {
  const testing::TemporaryFolder camera;
  RigFixture bench(bench_options(plan, scene, seed, camera.path()));
  if (!bench.ready()) {
    tally.trouble += "\n  strobed did not come up:\n" + bench.log();
    return;
  }
  std::vector<std::string> words{"--photographs", camera.path(), "--effort", plan.effort};
  if (train == "even") words.insert(words.end(), {"--spacing", "even"});
  const auto fired =
      testing::run_process(bench.fire(shots, 2 * shots, words), std::chrono::seconds{60 + 120 * shots});
  const auto lost = rejections(fired.err);
  const auto truths = bench.truths();
  tally.asked += shots;
  for (const auto& readout : readouts(fired.out)) {
    ++tally.fired;
    const int shot = readout.at("shot_id").get<int>();
    const auto why = lost.find(shot);
    if (why != lost.end()) {
      ++tally.rejected[why->second];
      if (why->second.find("which flash made which image") != std::string::npos) ++tally.ambiguous;
    } else {
      ++tally.came;
    }
    if (why == lost.end())
      count(readout, truth_of(truths, readout), fmt::format("seed {} shot {}", seed, shot), tally);
  }
  if (fired.status != testing::ExitStatus({0, 0}))
    tally.trouble += "\n  strobe fire: " +
                     fired.err.substr(fired.err.size() - std::min<std::size_t>(fired.err.size(), 300));
  if (!plan.keep.empty())
    keep(bench, fired, fs::path(plan.keep) / fmt::format("{}-{}-{}", scene, train, seed));
}

double percent(int part, int whole) { return whole > 0 ? 100.0 * part / whole : 0.0; }

void print(const std::string& scene, const std::string& train, const Tally& t) {
  fmt::print("{} {}: {} fired, {} came, {} ({:.1f} %) rejected for ambiguity\n", scene, train, t.fired,
             t.came, t.ambiguous, percent(t.ambiguous, t.fired));
  for (const auto& [why, times] : t.rejected) fmt::print("    rejected {}: {}\n", times, why);
  fmt::print("    of those that came: outlier_image {} ({:.1f} %), flashes named {}, of these wrongly {}\n",
             t.outliers, percent(t.outliers, t.came), t.named, t.misnamed);
  std::vector<std::string> flags, errors;
  for (const auto& [flag, times] : t.flags) flags.push_back(fmt::format("{} {}", flag, times));
  if (!flags.empty()) fmt::print("    flags: {}\n", fmt::join(flags, ", "));
  for (const std::string& quantity : kEssential)
    if (const auto rms = t.score.rms_of(quantity)) errors.push_back(fmt::format("{} {:.2f}", quantity, *rms));
  fmt::print("    rms errors over stated sds: {}\n", fmt::join(errors, ", "));
  if (const std::string beyond = t.score.beyond(4.5); !beyond.empty())
    fmt::print("    beyond 4.5 sd:{}\n", beyond);
  if (!t.trouble.empty()) fmt::print("    trouble:{}\n", t.trouble);
  std::fflush(stdout);
}

int run(const Plan& plan) {
  bool trouble = false;
  for (const std::string& scene : plan.scenes) {
    for (const std::string& train : plan.trains) {
      Tally tally;
      std::uint64_t seed = plan.seed;
      for (int left = plan.shots; left > 0; left -= plan.batch) {
        fire_batch(plan, scene, train, seed++, std::min(left, plan.batch), tally);
        fmt::print(stderr, "{} {}: {} of {} came, {} fired\n", scene, train, tally.came, plan.shots,
                   tally.fired);
      }
      print(scene, train, tally);
      trouble = trouble || !tally.trouble.empty();
    }
  }
  return trouble ? kFailed : kDone;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Fires shots at scenes through the shipped programs, with photographs, and holds the readouts against "
      "the truth.");
  Plan plan;
  app.add_option("scenes", plan.scenes, "Scenes (default: five that are hard to match)");
  app.add_option("--shots", plan.shots, "of each scene and train that must come (default 200)")
      ->check(CLI::Range(1, 100000));
  app.add_option("--train", plan.trains,
                 "default, even: as strobe fire has it, or with --spacing even (default: both)")
      ->check(CLI::IsMember({"default", "even"}));
  app.add_option("--seed", plan.seed, "of the first batch; each next one has the next (default 1)");
  app.add_option("--batch", plan.batch,
                 "shots of one start of the programs; its photographs are on the disk meanwhile (default 20)")
      ->check(CLI::Range(1, 1000));
  app.add_option("--effort", plan.effort, "as of strobe fire (default standard)")
      ->check(CLI::IsMember({"fast", "standard", "thorough"}));
  app.add_option("--flash-time-sd-us", plan.flash_time_sd_us,
                 "as in the rig file (default: the shipped one's, 2; the simulated sensors' is 0.2)")
      ->check(CLI::Range(0.01, 100.0));
  app.add_option("--keep", plan.keep,
                 "folder for readouts, truth, logs and the photographs of shots rejected or flagged");
  app.footer(
      "Example: strobe-fire-study itf_pace_medium zero_23 --shots 20 --keep lost\n"
      "Exit status: 0 fired, 1 a program failed.");
  CLI11_PARSE(app, argc, argv);
  const testing::IsolatedEnvironment isolated;
  return run(plan);
}
