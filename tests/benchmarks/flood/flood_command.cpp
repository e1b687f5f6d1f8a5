// strobe-bench flood: lateness of strobed's flashes while a stranger floods the command channel at the
// machine's full rate, beside shots without, in turns, on the shipped binaries.
#include <pthread.h>
#include <sched.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/benchmarks/command.hpp"
#include "tests/benchmarks/timing/freeze_detector.hpp"
#include "tests/benchmarks/timing/figures.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using benchmarks::timing::FreezeDetector;
using benchmarks::timing::Sample;

constexpr const char* kOwn = "own";
constexpr const char* kShared = "shared";

struct Options {
  int rounds = 6, senders = 2, priority = 80, cpu = -1;
  std::vector<int> sender_cpus;
  std::vector<std::string> layouts{kOwn, kShared};
  bool json = false;
};

/// Where everything runs.
struct Layout {
  std::string name;
  int loop_cpu = -1;             ///< -1: any
  std::vector<int> sender_cpus;  ///< in turn
  std::vector<int> other_cpus;   ///< of all other threads
};

std::vector<int> cpus() {
  std::vector<int> all(std::max(1U, std::thread::hardware_concurrency()));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// "own": the loop has the last core, or --cpu, to itself. "shared": it runs anywhere, or on --cpu, and
/// senders on all cores.
Layout layout_of(const std::string& name, const Options& options) {
  Layout layout{name, options.cpu, options.sender_cpus, cpus()};
  if (name == kOwn) {
    if (layout.loop_cpu < 0) layout.loop_cpu = layout.other_cpus.back();
    std::erase(layout.other_cpus, layout.loop_cpu);
    if (layout.other_cpus.empty()) throw std::runtime_error("a core of its own needs two cores");
  }
  if (layout.sender_cpus.empty()) layout.sender_cpus = layout.other_cpus;
  return layout;
}

/// The calling thread, and all that it starts, runs on these CPUs as long as this lives.
class Placed {
 public:
  explicit Placed(const std::vector<int>& cpus) {
    pthread_getaffinity_np(pthread_self(), sizeof before_, &before_);
    cpu_set_t set;
    CPU_ZERO(&set);
    for (const int cpu : cpus) CPU_SET(static_cast<unsigned>(cpu), &set);
    if (pthread_setaffinity_np(pthread_self(), sizeof set, &set) != 0)
      throw std::runtime_error("cannot run on the CPUs that were asked for");
  }
  Placed(const Placed&) = delete;
  Placed& operator=(const Placed&) = delete;
  ~Placed() { pthread_setaffinity_np(pthread_self(), sizeof before_, &before_); }

 private:
  cpu_set_t before_{};
};

struct Span {
  std::int64_t begin_ns = 0, end_ns = 0;
};

struct Run {
  std::vector<Span> quiet, flooded;  ///< shots
  std::int64_t packets = 0;
  double flood_s = 0.0;
  std::int64_t events = 0, gaps = 0, shots_whole = 0, shots = 0;
  std::vector<Sample> quiet_flashes, flooded_flashes;
  std::vector<benchmarks::timing::Freeze> freezes;
  FreezeDetector::Method by = FreezeDetector::Method::interrupts;
};

std::vector<std::unique_ptr<hil::Flooder>> start_flood(const std::string& url, const hil::Bytes& true_command,
                                                       int senders, const Layout& layout) {
  std::vector<std::unique_ptr<hil::Flooder>> flood;
  for (int i = 0; i < senders; ++i) {
    const Placed here({layout.sender_cpus[static_cast<std::size_t>(i) % layout.sender_cpus.size()]});
    flood.push_back(std::make_unique<hil::Flooder>(url, "bench", true_command));
  }
  return flood;
}

/// One dry shot of a second and a half at 3 ms.
Span shoot(hil::RawHost& host, const std::string& url, int senders, const Layout& layout, Run& run) {
  const std::int64_t token = host.arm();
  if (token == 0) throw std::runtime_error("no token was given");
  auto fire = host.fire_command(token, true);
  fire.plan.shutter_open_ns = 1'150'000'000;  // 383 flashes
  fire.plan.impact_at_ns = 600'000'000;
  host.send(fire);
  Span span{testing::monotonic_now_ns(), 0};
  {
    // Starts while the shutter opens, and lasts until the shot is over.
    const auto flood = start_flood(url, host.sealed(fire, host.key()), senders, layout);
    testing::sleep_for(std::chrono::milliseconds(1400));
    span.end_ns = testing::monotonic_now_ns();
    for (const auto& sender : flood) run.packets += sender->stop();
    if (senders > 0) run.flood_s += static_cast<double>(span.end_ns - span.begin_ns) * 1e-9;
  }
  host.listen(std::chrono::milliseconds(300));
  return span;
}

void read_journal(const std::string& path, int cpu, Run& run) {
  const hil::LogContents log = hil::read_log(path);
  std::int64_t last = 0;
  for (const strobe_msgs::event_t& event : log.events) {
    ++run.events;
    if (event.sequence != ++last) ++run.gaps;
    last = event.sequence;
    const auto flash = benchmarks::timing::flash_of(event, cpu);
    if (!flash) continue;
    const auto within = [&](const Span& span) {
      return to_ns(flash->from) >= span.begin_ns && to_ns(flash->from) <= span.end_ns;
    };
    if (std::ranges::any_of(run.quiet, within)) run.quiet_flashes.push_back(*flash);
    if (std::ranges::any_of(run.flooded, within)) run.flooded_flashes.push_back(*flash);
  }
  run.shots = static_cast<std::int64_t>(log.shots.size());
  for (const auto& shot : log.shots) run.shots_whole += shot.aborted ? 0 : 1;
}

Run measure(const Options& options, const Layout& layout) {
  const Placed placed(layout.other_cpus);
  hil::RigFixtureOptions rig_options;
  rig_options.sim_options = {"--no-digitizer", "--time", "real"};
  rig_options.rig_edits = {{"\ncpu = -1", "\ncpu = " + std::to_string(layout.loop_cpu)},
                           {"\npriority = 80", "\npriority = " + std::to_string(options.priority)}};
  hil::RigFixture bench(rig_options);
  if (!bench.ready()) throw std::runtime_error("strobed does not start:\n" + bench.log());
  hil::RawHost host(bench);
  if (!host.wait_status()) throw std::runtime_error("strobed is not heard");
  Run run;
  FreezeDetector detector(options.priority - 10, FreezeDetector::Method::interrupts);
  for (int round = 1; round <= options.rounds; ++round) {
    std::fprintf(stderr, "%s, round %d of %d\n", layout.name.c_str(), round, options.rounds);
    run.quiet.push_back(shoot(host, bench.lcm_url(), 0, layout, run));
    run.flooded.push_back(shoot(host, bench.lcm_url(), options.senders, layout, run));
  }
  run.freezes = detector.stop();
  run.by = detector.by();
  const std::string journal = bench.journal();
  bench.finish();
  read_journal(journal, layout.loop_cpu, run);
  return run;
}

std::vector<benchmarks::timing::Row> rows_of(const Layout& layout, const Run& run) {
  using benchmarks::timing::latenesses;
  using benchmarks::timing::outside;
  using benchmarks::timing::percentiles;
  const benchmarks::timing::Percentiles quiet = percentiles(outside(run.quiet_flashes, run.freezes));
  const benchmarks::timing::Percentiles flooded = percentiles(outside(run.flooded_flashes, run.freezes));
  return {{layout.name, "quiet", "left out", quiet, -1.0, ""},
          {layout.name, "flooded", "left out", flooded, -1.0, benchmarks::timing::ratios(flooded, quiet)},
          {layout.name, "quiet", "included", percentiles(latenesses(run.quiet_flashes)), -1.0, ""},
          {layout.name, "flooded", "included", percentiles(latenesses(run.flooded_flashes)), -1.0, ""}};
}

void print_flood(const Layout& layout, const Run& run, bool json) {
  const double rate = run.flood_s > 0.0 ? static_cast<double>(run.packets) / run.flood_s : 0.0;
  if (json) {
    const nlohmann::json row{
        {"layout", layout.name},  {"loop_cpu", layout.loop_cpu},    {"sender_cpus", layout.sender_cpus},
        {"packets", run.packets}, {"packets_per_s", rate},          {"events_journalled", run.events},
        {"gaps", run.gaps},       {"shots_whole", run.shots_whole}, {"shots", run.shots}};
    std::printf("%s\n", row.dump().c_str());
    return;
  }
  std::string senders;
  for (const int cpu : layout.sender_cpus) senders += " " + std::to_string(cpu);
  std::printf("%s: loop on %s, senders on CPU%s; %lld packets, %.0f a second; %lld events journalled, ",
              layout.name.c_str(),
              layout.loop_cpu < 0 ? "any CPU" : ("CPU " + std::to_string(layout.loop_cpu)).c_str(),
              senders.c_str(), static_cast<long long>(run.packets), rate, static_cast<long long>(run.events));
  std::printf("%lld gaps; %lld of %lld shots whole; %s\n", static_cast<long long>(run.gaps),
              static_cast<long long>(run.shots_whole), static_cast<long long>(run.shots),
              benchmarks::timing::freezes_in_words(run.freezes, run.by).c_str());
}

int flood(const Options& options) {
  testing::enter_private_network();
  const testing::TemporaryFolder configuration;
  setenv("XDG_CONFIG_HOME", configuration.path().c_str(), 1);
  std::vector<benchmarks::timing::Row> rows;
  bool nothing_lost = true;
  for (const std::string& name : options.layouts) {
    const Layout layout = layout_of(name, options);
    const Run run = measure(options, layout);
    print_flood(layout, run, options.json);
    for (const benchmarks::timing::Row& row : rows_of(layout, run)) rows.push_back(row);
    nothing_lost &= run.gaps == 0 && run.shots == 2 * options.rounds;
  }
  benchmarks::timing::print_rows(rows, options.json, "over quiet");
  return nothing_lost ? 0 : 1;
}

}  // namespace

namespace strobe::benchmarks {

void add_flood_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("flood",
                         "lateness of strobed's flashes while a stranger floods its command "
                         "channel, in turns with quiet shots.\n"
                         "Example: strobe-bench flood --rounds 6 --senders 2 --cpu 1 --sender-cpus 0");
  command->add_option("--rounds", options->rounds, "quiet and flooded shots in turn")
      ->check(CLI::Range(1, 1000));
  command->add_option("--senders", options->senders, "threads that send as fast as they can")
      ->check(CLI::Range(1, 64));
  command->add_option("--priority", options->priority, "[real_time] priority of the rig file")
      ->check(CLI::Range(11, 98));
  command
      ->add_option("--layouts", options->layouts,
                   "own: the loop has a CPU to itself; shared: senders on every CPU; both by default")
      ->delimiter(',')
      ->check(CLI::IsMember({kOwn, kShared}));
  command->add_option("--cpu", options->cpu, "the loop's CPU; by default the last in own, any in shared")
      ->check(CLI::Range(0, 1023));
  command
      ->add_option("--sender-cpus", options->sender_cpus,
                   "CPUs of the senders in turn; by default all but the loop's in own, all in shared")
      ->delimiter(',')
      ->check(CLI::Range(0, 1023));
  command->add_flag("--json", options->json, "one JSON object per line");
  command->callback([options, &exit_status] { exit_status = flood(*options); });
}

}  // namespace strobe::benchmarks
