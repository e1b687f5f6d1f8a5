#include "tests/benchmarks/timing/runs.hpp"

#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <thread>

#include "sim/scene/scene.hpp"
#include "tests/benchmarks/timing/figures.hpp"
#include "tests/benchmarks/timing/freeze_detector.hpp"

namespace strobe::benchmarks::timing {
namespace {

sim::ChipSpec rig_chip() {
  sim::ChipSpec spec;
  for (const std::string_view name : sim::kLineNames) {
    const bool high = name == sim::name(sim::RigLine::key) || name == sim::name(sim::RigLine::estop);
    spec.lines.push_back({.name = std::string(name), .idle_level = high ? 1 : 0});
  }
  return spec;
}

sim::Chip make_chip(const std::filesystem::path& folder) {
  auto chip = sim::Chip::create(folder, rig_chip());
  if (!chip) throw std::runtime_error(chip.error().message);
  return std::move(*chip);
}

std::string command_line(const std::filesystem::path& folder, const LoopSettings& settings) {
  const auto library = sim::preload_path();
  if (!library) throw std::runtime_error(library.error().message);
  const std::string program = std::filesystem::canonical("/proc/self/exe");
  return std::string(sim::kChipDirVariable) + "='" + folder.string() + "' LD_PRELOAD='" + library->string() +
         "' '" + program + "' loop --seconds " + std::to_string(settings.seconds) + " --priority " +
         std::to_string(settings.priority) + " --cpu " + std::to_string(settings.cpu) + " --period-us " +
         std::to_string(settings.period / microseconds(1)) + " --spin-us " +
         std::to_string(settings.spin / microseconds(1)) +
         (settings.wake_ahead ? " --wake-ahead-us " + std::to_string(*settings.wake_ahead / microseconds(1))
                              : "");
}

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

struct LoopFixture::Waiter {
  explicit Waiter(const std::filesystem::path& folder)
      : chip(std::move(sim::Chip::attach(folder).value())), thread([this] { follow(); }) {}
  ~Waiter() {
    stop = true;
    thread.join();
  }
  void follow() {
    sim::ChangeCursor cursor = chip.cursor_now();
    std::vector<sim::Change> changes;
    while (!stop) {
      chip.wait_changes(cursor, now() + milliseconds(50), changes);
      changes.clear();
    }
  }
  sim::Chip chip;
  std::atomic<bool> stop{false};
  std::thread thread;
};

LoopFixture::LoopFixture()
    : folder_("/dev/shm/strobe-bench-loop-" + std::to_string(getpid())),
      chip_(make_chip(folder_)),
      waiter_(std::make_unique<Waiter>(folder_)) {}

LoopFixture::~LoopFixture() = default;

LoopRun LoopFixture::run(const LoopSettings& settings) {
  const std::string command = command_line(folder_, settings);
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
  if (!pipe) throw std::runtime_error("cannot run: " + command);
  LoopRun run;
  double cpu_s = 0.0;
  if (std::fscanf(pipe.get(), "%lf %d %d", &cpu_s, &run.shots, &run.aborted) != 3)
    throw std::runtime_error("the loop did not run: " + command);
  std::int64_t commanded_ns = 0, start_ns = 0;
  while (std::fscanf(pipe.get(), "%ld %ld", &commanded_ns, &start_ns) == 2) {
    run.issue.push_back(sample_of(from_ns(commanded_ns), from_ns(start_ns), settings.cpu));
  }
  if (run.issue.empty()) throw std::runtime_error("no flash was fired by: " + command);
  run.cpu_percent = 100.0 * cpu_s / (static_cast<double>(run.issue.size()) * to_seconds(settings.period));
  return run;
}

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

std::vector<Sample> run_cyclictest(const LoopSettings& like) {
  // chrt: the load must not hold its printing thread up for seconds, which would make the first line's second
  // another one.
  std::string command = "chrt -f 5 cyclictest -m -q -v -u -N -t 1 --secaligned=" +
                        std::to_string(kAfterSecond / microseconds(1)) + " -p " +
                        std::to_string(like.priority) + " -i " +
                        std::to_string(like.period / microseconds(1)) + " -D " + std::to_string(like.seconds);
  if (like.cpu >= 0) command += " -a " + std::to_string(like.cpu);
  command += " 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), &pclose);
  if (!pipe) throw std::runtime_error("cyclictest cannot be started (Debian package rt-tests)");
  std::vector<Duration> lateness;
  MonoTime first_heard;
  std::array<char, 256> line{};
  while (std::fgets(line.data(), static_cast<int>(line.size()), pipe.get())) {
    int thread = 0;
    long index = 0;
    long lateness_ns = 0;
    if (std::sscanf(line.data(), " %d: %ld: %ld", &thread, &index, &lateness_ns) != 3) continue;
    if (lateness.empty()) first_heard = now();
    if (index != static_cast<long>(lateness.size()))
      throw std::runtime_error("cyclictest left wake-ups out of what it printed");
    lateness.push_back(nanoseconds(lateness_ns));
  }
  if (lateness.empty())
    throw std::runtime_error("cyclictest printed no samples (Debian package rt-tests; needs root or rtprio)");
  return wake_ups_of(lateness, first_heard, like.period, like.cpu);
}

}  // namespace strobe::benchmarks::timing
