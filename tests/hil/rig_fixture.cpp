#include "tests/hil/rig_fixture.hpp"

#include <pthread.h>
#include <sched.h>

#include <csignal>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "tests/support/json_lines.hpp"
#include "tests/support/private_network.hpp"

namespace strobe::hil {

using testing::Command;
using namespace std::chrono_literals;

std::int64_t hang_known_within() {
  static const bool real_time = [] {
    bool granted = false;
    std::thread([&granted] {
      const sched_param wanted{81};  // the guardian's
      granted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted) == 0;
    }).join();
    return granted;
  }();
  return (real_time ? 400 : 850) * std::int64_t{1'000'000};
}

std::filesystem::path program(const std::string& name) {
  const char* const firmware = std::getenv("STROBE_HIL_STROBED");
  if (name == "strobed" && firmware != nullptr) return firmware;
  return std::filesystem::path(STROBE_BUILD_DIR) / "bin" / name;
}

std::map<std::string, std::string> environment_of_chip(const std::filesystem::path& chip_dir) {
  return {{"LD_PRELOAD", std::filesystem::path(STROBE_BUILD_DIR) / "lib/libstrobe-gpiochip.so"},
          {"STROBE_GPIOCHIP_DIR", chip_dir}};
}

std::filesystem::path share(const std::filesystem::path& name) {
  return std::filesystem::path(STROBE_BUILD_DIR) / "share/strobe" / name;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("nothing to replace: " + from);
  for (; at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
  return text;
}

namespace {

std::string edited(std::string text, const std::vector<std::pair<std::string, std::string>>& edits) {
  for (const auto& [from, to] : edits) text = replaced(std::move(text), from, to);
  return text;
}

/// The rig file as shipped, or for a loop that is not awake before each flash: $STROBE_HIL_WAKE_AHEAD is 0 where
/// another rig runs beside this one.
std::string shipped_rig() {
  const std::string text = testing::read_text(share("rig.toml"));
  const char* const wake_ahead = std::getenv("STROBE_HIL_WAKE_AHEAD");
  if (wake_ahead == nullptr) return text;
  return replaced(text, "wake_ahead_us = 4000", std::string("wake_ahead_us = ") + wake_ahead);
}

/// Its lines on the flash sequencer that strobe-sim has beside that chip.
std::string on_sequencer(std::string text, const std::filesystem::path& chip_dir) {
  const std::size_t begin = text.find("[chip]"), end = text.find("[lamps]");
  return text.replace(begin, end - begin, "[sequencer]\nport = \"" + (chip_dir / "sequencer").string() + "\"\n\n");
}

}  // namespace

RigFixture::RigFixture(const RigFixtureOptions& options)
    : lcm_url_(options.lcm_url.empty() ? testing::private_lcm_url() : options.lcm_url),
      sim_([this, &options] {
        const std::string scene = testing::read_text(share("scenes") / (options.scene + ".toml"));
        testing::write_text(folder_ / (options.scene + ".toml"),
                            edited(scene, options.scene_edits) + "\n" + options.scene_addition + "\n");
        std::string rig = options.scene_rig ? rig_of_scene(options) : shipped_rig();
        if (options.sequencer) rig = on_sequencer(std::move(rig), chip_dir());
        testing::write_text(rig_file(), edited(std::move(rig), options.rig_edits));
        std::filesystem::create_directory(session());
        return testing::Process(sim_command(options), folder_.path());
      }()) {}

std::string RigFixture::rig_of_scene(const RigFixtureOptions& options) const {
  const std::filesystem::path written = folder_ / "scene_rig.toml";
  const testing::CompletedProcess done =
      testing::run_process({{program("strobe-sim"), "run", "--scene", folder_ / (options.scene + ".toml"), "--photographs",
                             folder_ / "photographs", "--write-rig", written},
                            {},
                            {},
                            {}},
                           kLongestWait);
  if (done.status != testing::ExitStatus({0, 0})) throw std::runtime_error("no rig file: " + done.err);
  return testing::read_text(written);
}

Command RigFixture::sim_command(const RigFixtureOptions& options) const {
  Command command;
  command.rights = options.rights;
  command.environment = options.environment;
  command.arguments = {program("strobe-sim"),
                       "run",
                       "--scene",
                       folder_ / (options.scene + ".toml"),
                       "--seed",
                       std::to_string(options.seed),
                       "--lcm-url",
                       lcm_url_,
                       "--chip-dir",
                       chip_dir(),
                       "--truth",
                       folder_ / "truth.jsonl",
                       "--changes",
                       folder_ / "changes.csv"};
  const auto add = [&](const std::vector<std::string>& words) {
    command.arguments.insert(command.arguments.end(), words.begin(), words.end());
  };
  add(options.sim_options);
  if (options.sequencer) add({"--sequencer"});
  if (options.scene_rig) add({"--photographs", folder_ / "photographs"});
  add({"--"});
  if (!options.shell.empty()) add({"sh", "-c", options.shell, "sh"});
  // --allow-no-rt: a container's root may lack the right; strobed takes real-time priority wherever it can.
  add({program("strobed"), "--config", rig_file(), "--session", session(), "--lcm-url", lcm_url_,
       "--allow-no-rt"});
  add(options.strobed_options);
  return command;
}

bool RigFixture::ready() { return sim_.wait_for_err("strobed: ready", kLongestWait); }

namespace {

std::vector<pid_t> daemons_under(pid_t sim) {
  std::vector<pid_t> daemons;
  for (const pid_t pid : testing::descendants_of(sim))
    if (testing::program_of(pid) == "strobed") daemons.push_back(pid);
  return daemons;
}

}  // namespace

pid_t RigFixture::guardian() const {
  const std::vector<pid_t> daemons = daemons_under(sim_.pid());
  return daemons.empty() ? 0 : daemons[0];
}

pid_t RigFixture::worker() const {
  const std::vector<pid_t> daemons = daemons_under(sim_.pid());
  return daemons.size() < 2 ? 0 : daemons[1];
}

std::filesystem::path RigFixture::journal() const {
  std::filesystem::path newest;
  for (const auto& entry : std::filesystem::directory_iterator(session())) {
    if (entry.path().filename().string().rfind("journal-", 0) != 0) continue;
    if (newest.empty() || entry.last_write_time() > std::filesystem::last_write_time(newest))
      newest = entry.path();
  }
  return newest;
}

Command RigFixture::strobe(std::vector<std::string> words) const {
  Command command;
  const bool speaks = words.at(0) == "fire" || words.at(0) == "live";
  words.insert(words.begin(), program("strobe"));
  words.insert(words.end(), {"--rig", rig_file()});
  if (speaks) words.insert(words.end(), {"--lcm-url", lcm_url_});
  command.arguments = std::move(words);
  if (speaks) command.environment = environment_of_chip(chip_dir());  // it lives in the rig's time
  return command;
}

Command RigFixture::fire(int shots, int retries, const std::vector<std::string>& more) const {
  std::vector<std::string> words{
      "fire",    "--shots", std::to_string(shots), "--retries", std::to_string(retries), "--session",
      session(), "--json"};
  words.insert(words.end(), more.begin(), more.end());
  return strobe(std::move(words));
}

testing::CompletedProcess RigFixture::refused(const Command& fire, const std::string& reason) const {
  testing::CompletedProcess done;
  for (const int wait_s : {1, 4, 16}) {
    Command command = fire;
    command.arguments.insert(command.arguments.end(), {"--wait", std::to_string(wait_s)});
    done = testing::run_process(command, std::chrono::seconds{60});
    if (done.err.find(reason) != std::string::npos) break;
  }
  return done;
}

Command RigFixture::strobed(const std::vector<std::string>& words) const {
  Command command;
  command.arguments = {program("strobed")};
  command.arguments.insert(command.arguments.end(), words.begin(), words.end());
  command.environment = environment_of_chip(chip_dir());
  return command;
}

void RigFixture::drive(const std::string& line_and_level) const {
  const testing::CompletedProcess finished = testing::run_process(
      {{program("strobe-sim"), "drive", "--chip-dir", chip_dir(), line_and_level}, {}, {}, {}}, 10s);
  if (finished.status != testing::ExitStatus({0, 0}))
    throw std::runtime_error("cannot drive: " + finished.err);
}

LineChanges RigFixture::finish() {
  sim_.signal(SIGTERM);
  if (!sim_.wait(20s)) throw std::runtime_error("strobe-sim does not end: " + log());
  return changes();
}

LineChanges RigFixture::changes() {
  if (!sim_.wait(20s)) throw std::runtime_error("strobe-sim does not end: " + log());
  return LineChanges(folder_ / "changes.csv");
}

std::vector<nlohmann::json> RigFixture::truths() const {
  return testing::read_json_lines(folder_ / "truth.jsonl");
}

std::vector<nlohmann::json> readouts(const std::string& out) {
  // The last line of a program that still runs may be there in part.
  std::vector<nlohmann::json> found = testing::parse_json_lines(out.substr(0, out.rfind('\n') + 1));
  std::erase_if(found, [](const nlohmann::json& value) {
    return !value.contains("shot_id") || !value.contains("vx_td_mps");
  });
  return found;
}

std::string readout_lines(const std::string& out) {
  std::string lines;
  std::istringstream stream(out);
  for (std::string line; std::getline(stream, line);)
    if (!readouts(line + "\n").empty()) lines += line + "\n";
  return lines;
}

bool has_flag(const nlohmann::json& readout, const std::string& flag) {
  for (const auto& each : readout.at("flags"))
    if (each.get<std::string>() == flag) return true;
  return false;
}

}  // namespace strobe::hil
