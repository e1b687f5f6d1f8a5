// strobe-bench timing: lateness of strobed's flashes beside cyclictest's, interleaved in one run.
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

#include "tests/bench/command.hpp"
#include "tests/bench/timing/sample.hpp"
#include "tests/bench/timing/witness.hpp"

namespace {

using strobe::bench::FlashSamples;
using strobe::bench::Freeze;
using strobe::bench::Percentiles;
using strobe::bench::Sample;

struct Options {
  int rounds = 3;
  int seconds = 15;
  int priority = 80;
};

std::filesystem::path own_folder() { return std::filesystem::canonical("/proc/self/exe").parent_path(); }

void run(const std::string& command, const std::filesystem::path& log) {
  const int status = std::system((command + " >> " + log.string() + " 2>&1").c_str());
  if (status == -1 || !WIFEXITED(status)) throw std::runtime_error("cannot run: " + command);
}

void append(std::vector<Sample>& to, const std::vector<Sample>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

// Dry shots (lamps and shutter only) through the shipped binaries, until the time is over.
FlashSamples fire_dry_shots(const std::filesystem::path& folder, const Options& options, int round) {
  const std::string bin = own_folder().string();
  const std::filesystem::path session = folder / ("round-" + std::to_string(round));
  std::filesystem::create_directories(session);
  const std::string url =
      "udpm://239.255.76.67:" + std::to_string(20000 + getpid() % 20000) + "?ttl=0&recv_buf_size=2097152";
  const int shots = std::max(1, options.seconds);  // a shot with its pauses takes about a second
  const std::string script = folder / "fire.sh";
  std::ofstream(script) << "rig=" << bin << "/../share/strobe/rig.toml\n"
                        << bin << "/strobe-sim run --scene zero_23 --no-digitizer --lcm-url '" << url
                        << "' -- " << bin << "/strobed --config $rig --session " << session << " --lcm-url '"
                        << url << "' --allow-no-rt &\nsim=$!\n"
                        << bin << "/strobe fire --rig $rig --dry --shots " << shots << " --retries " << shots
                        << " --session " << (session / "host") << " --lcm-url '" << url << "' --json\n"
                        << "kill $sim\nwait $sim\n";
  run("bash " + script, folder / "log.txt");
  FlashSamples samples;
  for (const auto& entry : std::filesystem::directory_iterator(session)) {
    if (!entry.path().filename().string().starts_with("journal-")) continue;
    const FlashSamples more = strobe::bench::flashes_of_journal(entry.path());
    append(samples.issue, more.issue);
    append(samples.done, more.done);
  }
  if (samples.issue.empty())
    throw std::runtime_error("no flash was fired: see " + (folder / "log.txt").string());
  return samples;
}

void print_row(const char* name, const Percentiles& p) {
  std::printf("%-34s %8zu %10.2f %10.2f %10.2f %12.2f\n", name, p.count, p.p50_us, p.p99_us, p.p999_us,
              p.max_us);
}

Percentiles all(const std::vector<Sample>& samples) {
  std::vector<double> values;
  for (const Sample& sample : samples) values.push_back(sample.lateness_us);
  return strobe::bench::percentiles(values);
}

Percentiles outside(const std::vector<Sample>& samples, const std::vector<Freeze>& freezes) {
  std::vector<double> values;
  for (const Sample& sample : samples) {
    if (!strobe::bench::within_freeze(freezes, sample.from, sample.to)) values.push_back(sample.lateness_us);
  }
  return strobe::bench::percentiles(values);
}

void report(const FlashSamples& loop, const std::vector<Sample>& cyclic, const std::vector<Freeze>& freezes) {
  double frozen_ms = 0.0;
  double longest_ms = 0.0;
  for (const Freeze& freeze : freezes) {
    frozen_ms += (freeze.end - freeze.begin).seconds() * 1e3;
    longest_ms = std::max(longest_ms, (freeze.end - freeze.begin).seconds() * 1e3);
  }
  std::printf("freezes of a core (> 1 ms): %zu, %.0f ms in all, longest %.1f ms\n", freezes.size(), frozen_ms,
              longest_ms);
  std::printf("%-34s %8s %10s %10s %10s %12s\n", "lateness [us]", "n", "p50", "p99", "p99.9", "max");
  print_row("strobed issue, outside freezes", outside(loop.issue, freezes));
  print_row("cyclictest, outside freezes", outside(cyclic, freezes));
  print_row("strobed issue, all", all(loop.issue));
  print_row("cyclictest, all", all(cyclic));
  print_row("strobed call done, outside freezes", outside(loop.done, freezes));
}

int timing(const Options& options) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("strobe-bench-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  strobe::bench::Witness witness(options.priority - 10);
  FlashSamples loop;
  std::vector<Sample> cyclic;
  for (int round = 1; round <= options.rounds; ++round) {
    std::fprintf(stderr, "round %d of %d: strobed ...\n", round, options.rounds);
    const FlashSamples shots = fire_dry_shots(folder, options, round);
    append(loop.issue, shots.issue);
    append(loop.done, shots.done);
    std::fprintf(stderr, "round %d of %d: cyclictest ...\n", round, options.rounds);
    const auto wakeups =
        strobe::bench::run_cyclictest(options.priority, strobe::milliseconds(3), options.seconds);
    append(cyclic, wakeups);
  }
  report(loop, cyclic, witness.stop());
  std::filesystem::remove_all(folder);
  return 0;
}

}  // namespace

namespace strobe::bench {

void add_timing_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("timing",
                         "lateness of strobed's flashes beside cyclictest's, in turns, on the shipped "
                         "binaries.\nExample: strobe-bench timing --rounds 3 --seconds 15");
  command->add_option("--rounds", options->rounds, "rounds of strobed and cyclictest in turn")
      ->check(CLI::Range(1, 1000));
  command->add_option("--seconds", options->seconds, "length of each part")->check(CLI::Range(1, 3600));
  command
      ->add_option("--priority", options->priority,
                   "real-time priority of cyclictest, as [real_time] priority of the rig file")
      ->check(CLI::Range(11, 98));
  command->callback([options, &exit_status] { exit_status = timing(*options); });
}

}  // namespace strobe::bench
