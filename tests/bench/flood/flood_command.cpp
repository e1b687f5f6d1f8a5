// strobe-bench flood: lateness of strobed's flashes while a stranger floods the command channel at the
// machine's full rate, beside shots without, in turns, on the shipped binaries.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/bench/command.hpp"
#include "tests/bench/timing/sample.hpp"
#include "tests/bench/timing/witness.hpp"
#include "tests/hil/bench.hpp"
#include "tests/hil/flooder.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using bench::timing::Percentiles;
using bench::timing::Sample;

struct Options {
  int rounds = 6;
  int senders = 2;
  int priority = 80;
  bool json = false;
};

struct Span {
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;
};

struct Run {
  std::vector<Span> quiet, flooded;  ///< shots
  std::int64_t packets = 0;
  double flood_s = 0.0;
  std::int64_t events = 0, gaps = 0, shots_whole = 0, shots = 0;
  std::vector<Sample> quiet_flashes, flooded_flashes;
};

/// One dry shot of a second and a half at 3 ms.
Span shoot(hil::RawHost& host, const std::string& url, int senders, Run& run) {
  const std::int64_t token = host.arm();
  if (token == 0) throw std::runtime_error("no token was given");
  auto fire = host.fire_command(token, true);
  fire.plan.shutter_open_ns = 1'150'000'000;  // 383 flashes
  fire.plan.impact_at_ns = 600'000'000;
  host.send(fire);
  Span span{testing::monotonic_now_ns(), 0};
  {
    // Starts while the shutter opens, and lasts until the shot is over.
    std::vector<std::unique_ptr<hil::Flooder>> flood;
    for (int i = 0; i < senders; ++i)
      flood.push_back(std::make_unique<hil::Flooder>(url, "bench", host.sealed(fire, host.key())));
    testing::sleep_for(std::chrono::milliseconds(1400));
    span.end_ns = testing::monotonic_now_ns();
    for (const auto& sender : flood) run.packets += sender->stop();
    if (senders > 0) run.flood_s += static_cast<double>(span.end_ns - span.begin_ns) * 1e-9;
  }
  host.listen(std::chrono::milliseconds(300));
  return span;
}

void read_journal(const std::string& path, Run& run) {
  using strobe_msgs::event_t;
  const hil::LogContents log = hil::read_log(path);
  std::int64_t last = 0;
  for (const event_t& event : log.events) {
    ++run.events;
    if (event.sequence != ++last) ++run.gaps;
    last = event.sequence;
    if (event.kind != event_t::FLASH) continue;
    const Sample sample{MonoTime{event.commanded_ns - 300'000}, MonoTime{event.issue_start_ns},
                        static_cast<double>(event.issue_start_ns - event.commanded_ns) * 1e-3};
    const auto within = [&](const Span& span) {
      return event.commanded_ns >= span.begin_ns && event.commanded_ns <= span.end_ns;
    };
    if (std::ranges::any_of(run.quiet, within)) run.quiet_flashes.push_back(sample);
    if (std::ranges::any_of(run.flooded, within)) run.flooded_flashes.push_back(sample);
  }
  run.shots = static_cast<std::int64_t>(log.shots.size());
  for (const auto& shot : log.shots) run.shots_whole += shot.aborted ? 0 : 1;
}

Percentiles figures(const std::vector<Sample>& samples, const std::vector<bench::timing::Freeze>& freezes,
                    bool with_freezes) {
  std::vector<double> values;
  for (const Sample& sample : samples) {
    if (with_freezes || !bench::timing::within_freeze(freezes, sample.from, sample.to))
      values.push_back(sample.lateness_us);
  }
  return bench::timing::percentiles(std::move(values));
}

void print_row(const char* name, const char* freezes, const Percentiles& p, bool json) {
  if (json) {
    const nlohmann::json row{{"what", name},       {"freezes", freezes}, {"n", p.count},
                             {"p50_us", p.p50_us}, {"p99_us", p.p99_us}, {"p999_us", p.p999_us},
                             {"max_us", p.max_us}};
    std::printf("%s\n", row.dump().c_str());
  } else {
    std::printf("%-10s %-9s %8zu %10.2f %10.2f %10.2f %12.2f\n", name, freezes, p.count, p.p50_us, p.p99_us,
                p.p999_us, p.max_us);
  }
}

void report(const Run& run, const std::vector<bench::timing::Freeze>& freezes, bool json) {
  const double rate = run.flood_s > 0.0 ? static_cast<double>(run.packets) / run.flood_s : 0.0;
  if (!json) {
    std::printf("%-10s %-9s %8s %10s %10s %10s %12s\n", "shots", "freezes", "n", "p50 [us]", "p99", "p99.9",
                "max");
  }
  for (const bool with : {false, true}) {
    const char* freezes_are = with ? "included" : "left out";
    print_row("quiet", freezes_are, figures(run.quiet_flashes, freezes, with), json);
    print_row("flooded", freezes_are, figures(run.flooded_flashes, freezes, with), json);
  }
  const double ratio =
      figures(run.flooded_flashes, freezes, false).p99_us / figures(run.quiet_flashes, freezes, false).p99_us;
  if (json) {
    const nlohmann::json row{
        {"packets", run.packets}, {"packets_per_s", rate},          {"events_journalled", run.events},
        {"gaps", run.gaps},       {"shots_whole", run.shots_whole}, {"shots", run.shots},
        {"p99_ratio", ratio}};
    std::printf("%s\n", row.dump().c_str());
  } else {
    std::printf("p99 flooded over quiet, freezes left out: %.2f\n", ratio);
    std::printf(
        "flood: %lld packets, %.0f a second; %lld events journalled, %lld gaps; %lld of %lld shots whole\n",
        static_cast<long long>(run.packets), rate, static_cast<long long>(run.events),
        static_cast<long long>(run.gaps), static_cast<long long>(run.shots_whole),
        static_cast<long long>(run.shots));
  }
}

int flood(const Options& options) {
  testing::enter_private_network();
  const testing::TemporaryFolder configuration;
  setenv("XDG_CONFIG_HOME", configuration.path().c_str(), 1);
  hil::BenchOptions bench_options;
  bench_options.sim_options = {"--no-digitizer"};
  hil::Bench bench(bench_options);
  if (!bench.ready()) throw std::runtime_error("strobed does not start:\n" + bench.log());
  hil::RawHost host(bench.lcm_url(), "bench");
  if (!host.wait_status()) throw std::runtime_error("strobed is not heard");
  Run run;
  bench::timing::Witness witness(options.priority - 10);
  for (int round = 1; round <= options.rounds; ++round) {
    std::fprintf(stderr, "round %d of %d\n", round, options.rounds);
    run.quiet.push_back(shoot(host, bench.lcm_url(), 0, run));
    run.flooded.push_back(shoot(host, bench.lcm_url(), options.senders, run));
  }
  const auto freezes = witness.stop();
  const std::string journal = bench.journal();
  bench.finish();
  read_journal(journal, run);
  report(run, freezes, options.json);
  return run.gaps == 0 && run.shots == 2 * options.rounds ? 0 : 1;
}

}  // namespace

namespace strobe::bench {

void add_flood_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("flood",
                                         "lateness of strobed's flashes while a stranger floods its command "
                                         "channel, in turns with quiet shots.\n"
                                         "Example: strobe-bench flood --rounds 6 --senders 2");
  command->add_option("--rounds", options->rounds, "quiet and flooded shots in turn")
      ->check(CLI::Range(1, 1000));
  command->add_option("--senders", options->senders, "threads that send as fast as they can")
      ->check(CLI::Range(1, 64));
  command->add_option("--priority", options->priority, "[real_time] priority of the rig file")
      ->check(CLI::Range(11, 98));
  command->add_flag("--json", options->json, "one JSON object per line");
  command->callback([options, &exit_status] { exit_status = flood(*options); });
}

}  // namespace strobe::bench
