#include "tests/benchmarks/timing/programs.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <strobe_msgs/event_t.hpp>

#include "tests/benchmarks/timing/journalled_flash.hpp"

namespace strobe::benchmarks::timing {

namespace {

void add_flashes(const std::string& journal, int cpu, LoopRun& run) {
  lcm::LogFile log(journal, "r");
  if (!log.good()) throw std::runtime_error(journal + ": cannot be read");
  while (const lcm::LogEvent* entry = log.readNextEvent()) {
    if (!entry->channel.ends_with("/EVENT")) continue;
    strobe_msgs::event_t event;
    if (event.decode(entry->data, 0, entry->datalen) < 0) continue;
    if (event.kind == strobe_msgs::event_t::SHOT_STARTED) ++run.shots;
    if (event.kind == strobe_msgs::event_t::SHOT_ABORTED) ++run.aborted;
    if (const auto flash = flash_of(event, cpu)) run.issue.push_back(*flash);
    if (event.kind != strobe_msgs::event_t::FLASH) continue;
    run.done.push_back(sample_of(from_ns(event.commanded_ns), from_ns(event.issue_end_ns), cpu));
    run.call.push_back(sample_of(from_ns(event.issue_start_ns), from_ns(event.issue_end_ns), cpu));
  }
}

std::string with_real_time(std::string rig, const LoopSettings& like) {
  const auto replace = [&rig](const std::string& key, int value) {
    const std::size_t at = rig.find("\n" + key + " = ");
    if (at == rig.npos) throw std::runtime_error("the shipped rig file has no " + key);
    const std::size_t end = rig.find('\n', at + 1);
    rig.replace(at, end - at, "\n" + key + " = " + std::to_string(value));
  };
  replace("priority", like.priority);
  replace("cpu", like.cpu);
  return rig;
}

}  // namespace

LoopRun run_programs(const LoopSettings& like, const std::filesystem::path& folder,
                     const std::filesystem::path& strobed, const std::string& time) {
  const std::string bin = std::filesystem::canonical("/proc/self/exe").parent_path();
  const std::filesystem::path session = folder / "session";
  std::filesystem::remove_all(session);
  std::filesystem::create_directories(session);
  std::ifstream shipped(bin + "/../share/strobe/rig.toml");
  std::ostringstream rig;
  rig << shipped.rdbuf();
  std::ofstream(folder / "rig.toml") << with_real_time(rig.str(), like);
  const std::string url =
      "udpm://239.255.76.67:" + std::to_string(20000 + getpid() % 20000) + "?ttl=0&recv_buf_size=2097152";
  const int shots = std::max(1, like.seconds);
  const std::filesystem::path script = folder / "fire.sh";
  // A key of its own: both programs find it there.
  std::ofstream(script) << "export XDG_CONFIG_HOME='" << folder.string() << "'\nrig='"
                        << (folder / "rig.toml").string() << "'\n"
                        << bin << "/strobe-sim run --time " << time
                        << " --scene zero_23 --no-digitizer --lcm-url '" << url << "' -- "
                        << (strobed.empty() ? bin + "/strobed" : strobed.string())
                        << " --config $rig --session " << session << " --lcm-url '" << url
                        << "' --allow-no-rt &\nsim=$!\n"
                        << bin << "/strobe fire --rig $rig --dry --shots " << shots << " --retries " << shots
                        << " --session " << (session / "host") << " --lcm-url '" << url
                        << "' --json\nkill $sim\nwait $sim\n";
  const std::filesystem::path log = folder / "log.txt";
  const int status = std::system(("bash " + script.string() + " >> " + log.string() + " 2>&1").c_str());
  if (status == -1 || !WIFEXITED(status)) throw std::runtime_error("cannot run " + script.string());
  LoopRun run;
  for (const auto& entry : std::filesystem::directory_iterator(session))
    if (entry.path().filename().string().starts_with("journal-")) add_flashes(entry.path(), like.cpu, run);
  if (run.issue.empty()) throw std::runtime_error("no flash was fired: see " + log.string());
  return run;
}

}  // namespace strobe::benchmarks::timing
