#include "tests/commission/commission_bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <set>

#include "tests/hil/rig_fixture.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace strobe::commission_bench {
namespace {

namespace fs = std::filesystem;
using hil::program;
using hil::replaced;
using testing::Command;
using namespace std::chrono_literals;

constexpr std::chrono::minutes kLongestRun{20};

/// What a person at the rig does to its lines when these words are shown.
const std::vector<std::pair<std::string, std::string>>& responses() {
  static const std::vector<std::pair<std::string, std::string>> all{
      {"key: have the key off", "KEY=0"},
      {"key: turn the key on", "KEY=1"},
      {"key: turn the key off", "KEY=0"},
      {"key_wire: turn the key on", "KEY=1"},
      {"key_wire: pull the wire of the key's line off the board", "KEY=open"},
      {"key_wire: put the wire back", "KEY=1"},
      {"estop: have the e-stop pressed", "ESTOP=0"},
      {"estop: release the e-stop", "ESTOP=1"},
      {"estop: press the e-stop", "ESTOP=0"},
      {"estop_wire: release the e-stop", "ESTOP=1"},
      {"estop_wire: pull the wire of the e-stop's line off the board", "ESTOP=open"},
      {"estop_wire: put the wire back", "ESTOP=1"}};
  return all;
}

class Bench {
 public:
  explicit Bench(const BenchOptions& options) : options_(options), url_(testing::private_lcm_url()) {}

  Outcome run() {
    Outcome outcome;
    const std::int64_t begun_ns = testing::monotonic_now_ns();
    write_files();
    testing::Process rig(rig_command(), folder_.path());
    if (!rig.wait_for_err("strobed: ready", hil::kLongestWait)) {
      outcome.trouble = "strobed is not ready: " + rig.err();
      return outcome;
    }
    testing::Process commission(commission_command(), folder_.path());
    const std::int64_t end_ns = begun_ns + std::chrono::nanoseconds(kLongestRun).count();
    while (commission.running() && outcome.trouble.empty() && testing::monotonic_now_ns() < end_ns) {
      if (!heed(commission.err())) outcome.trouble = "the rig has ended: " + rig.err();
      testing::sleep_for(20ms);
    }
    outcome.err = commission.err();
    if (commission.running() && outcome.trouble.empty())
      outcome.trouble = "strobe commission does not end: " + outcome.err;
    outcome.steps = testing::parse_json_lines(commission.out());
    outcome.seconds = 1e-9 * static_cast<double>(testing::monotonic_now_ns() - begun_ns);
    rig.signal(SIGTERM);
    rig.wait(60s);
    if (!options_.keep.empty()) {
      testing::write_text(file("commission.err"), outcome.err);
      testing::write_text(file("rig.err"), rig.err());
      fs::create_directories(options_.keep);
      fs::copy(folder_.path(), options_.keep,
               fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    }
    return outcome;
  }

 private:
  fs::path file(const char* name) const { return folder_ / name; }

  Command sim(const fs::path& scene) const {
    return {{program("strobe-sim"), "run", "--scene", scene, "--seed", std::to_string(options_.seed),
             "--lcm-url", url_, "--photographs", file("camera")},
            {},
            {},
            {}};
  }

  void write_files() {
    // A sound rig's file: an inherited scene is found beside the heir.
    testing::write_text(file("commission.toml"), testing::read_text(hil::share("scenes/commission.toml")));
    testing::write_text(file("zero_23.toml"), testing::read_text(hil::share("scenes/zero_23.toml")));
    testing::write_text(file("scene.toml"), "inherits = \"commission\"\n" + options_.scene + "\n");
    Command writing = sim(file("commission.toml"));
    writing.arguments.insert(writing.arguments.end(), {"--write-rig", file("rig.toml")});
    const auto written = testing::run_process(writing, 60s);
    if (written.status != testing::ExitStatus({0, 0})) throw std::runtime_error(written.err);
    std::string rig = testing::read_text(file("rig.toml"));
    // Callipers in ten places; a camera that takes its time.
    rig = replaced(rig, "photograph_timeout_s = 60.0", "photograph_timeout_s = 20.0");
    rig = replaced(rig, "diameter_sd_m = 0.0002", "diameter_sd_m = 0.0001");
    for (const auto& [from, to] : options_.rig_edits) rig = replaced(rig, from, to);
    rig += fmt::format("\n[commission]\nballs = {}\nboard_folder = \"board\"\nboard_spacing_mm = 60.0\n",
                       options_.balls) +
           options_.rig_tables;
    testing::write_text(file("rig.toml"), rig);
    fs::create_directories(file("session"));
    fs::create_directories(file("elsewhere"));  // where no camera writes
    const auto board = testing::run_process({{program("strobe-sim"), "board", "--scene", file("scene.toml"),
                                              "--spacing-mm", "60", "--slanted", "2", "--out", file("board")},
                                             {},
                                             {},
                                             {}},
                                            60s);
    if (board.status != testing::ExitStatus({0, 0})) throw std::runtime_error(board.err);
    fs::remove(file("board/truth.jsonl"));
  }

  Command rig_command() const {
    Command command = sim(file("scene.toml"));
    command.arguments.insert(
        command.arguments.end(),
        {"--chip-dir", file("chip"), "--truth", file("truth.jsonl"), "--", program("strobed"), "--config",
         file("rig.toml"), "--session", file("session"), "--allow-no-rt"});
    return command;
  }

  Command commission_command() const {
    Command command;
    command.environment = hil::environment_of_chip(file("chip"));
    command.arguments = {program("strobe"), "commission", "--rig",  file("rig.toml"), "--session",
                         file("session"),   "--yes",      "--json", "--wait",         "6"};
    for (const std::string& id : options_.only)
      command.arguments.insert(command.arguments.end(), {"--only", id});
    return command;
  }

  /// Does what has been asked for since the last look, in its order.
  bool heed(const std::string& err) {
    for (std::size_t end = err.find('\n', heeded_); end != std::string::npos; end = err.find('\n', heeded_)) {
      const std::string line = err.substr(heeded_, end - heeded_);
      heeded_ = end + 1;
      for (const auto& [words, response] : responses())
        if (line.find("  " + words) == 0 && !drive(response)) return false;
    }
    return true;
  }

  bool drive(const std::string& response) const {
    const auto done = testing::run_process(
        {{program("strobe-sim"), "drive", "--chip-dir", file("chip"), response}, {}, {}, {}}, 20s);
    return done.status == testing::ExitStatus({0, 0});
  }

  const BenchOptions& options_;
  testing::TemporaryFolder folder_;
  std::string url_;
  std::size_t heeded_ = 0;
};

}  // namespace

const nlohmann::json* Outcome::step(const std::string& id) const {
  const auto found =
      std::ranges::find_if(steps, [&](const nlohmann::json& step) { return step.at("step") == id; });
  return found == steps.end() ? nullptr : &*found;
}

std::vector<std::string> Outcome::failures() const {
  std::vector<std::string> ids;
  for (const nlohmann::json& step : steps)
    if (step.at("state") == "failed") ids.push_back(step.at("step").get<std::string>());
  return ids;
}

Outcome commission(const BenchOptions& options) { return Bench(options).run(); }

}  // namespace strobe::commission_bench
