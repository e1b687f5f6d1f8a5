// strobe-soak: many runs of the virtual lab, with faults; reports violated invariants.
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>

#include "tests/soak/lab.hpp"

using namespace strobe;
using namespace strobe::soak;

namespace {

constexpr int kShotsPerRun = 10;
constexpr int kDone = 0, kFailed = 1, kBadInput = 2;

struct Options {
  std::int64_t shots = 10'000, from = 0;
  std::uint64_t seed = 1;
  std::string faults = "wild", plan = "mixed", rig = STROBE_SHIPPED_RIG;
  int jobs = 1;
  bool trace = false, quiet = false;
};

struct Work {
  RigFiles files;
  FaultPlan faults;
  PlanKind plan = PlanKind::mixed;
};

int bad_input(const std::string& why) {
  fmt::print(stderr, "strobe-soak: {}\n", why);
  return kBadInput;
}

std::string repetition(const Options& options, std::int64_t run) {
  const std::string rig = options.rig == STROBE_SHIPPED_RIG ? "" : fmt::format(" --rig '{}'", options.rig);
  return fmt::format("strobe-soak --seed {} --faults {} --plan {} --from {} --shots {}{} --trace",
                     options.seed, options.faults, options.plan, run * kShotsPerRun, kShotsPerRun, rig);
}

SoakCounts run_lab(const Options& options, const Work& work, std::int64_t run) {
  RunSettings settings;
  settings.seed = options.seed;
  settings.run = run;
  settings.shots = kShotsPerRun;
  settings.faults = work.faults;
  settings.plan = work.plan;
  settings.trace = options.trace ? stdout : nullptr;
  Lab lab(work.files, settings);
  const SoakCounts counts = lab.run();
  for (const std::string& violation : lab.invariant_checker().violations())
    fmt::print(stderr, "VIOLATION: {}\n  repeat it: {}\n", violation, repetition(options, run));
  return counts;
}

std::pair<std::int64_t, std::int64_t> runs_of(const Options& options) {
  const std::int64_t first = options.from / kShotsPerRun;
  return {first, first + (options.shots + kShotsPerRun - 1) / kShotsPerRun};
}

/// The runs of one process, reported to the parent ten times a second.
void run_share(const Options& options, const Work& work, int job, int pipe_end) {
  using Clock = std::chrono::steady_clock;
  const auto [first, end] = runs_of(options);
  SoakCounts fresh;
  auto reported = Clock::now();
  const auto report = [&] {
    if (write(pipe_end, &fresh, sizeof fresh) != sizeof fresh) _exit(kFailed);
    fresh = {};
    reported = Clock::now();
  };
  for (std::int64_t run = first + job; run < end; run += options.jobs) {
    fresh.add(run_lab(options, work, run));
    if (Clock::now() - reported > std::chrono::milliseconds(100)) report();
  }
  report();
}

class Progress {
 public:
  explicit Progress(const Options& options) : options_(options) {}
  double elapsed_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  void show(const SoakCounts& counts) {
    const double now_s = elapsed_s();
    if (options_.quiet || options_.trace || now_s < shown_s_ + 2.0) return;
    shown_s_ = now_s;
    fmt::print(stderr, "strobe-soak: {} of {} shots wanted, {} fired, {:.0f} a second, {} violations\n",
               counts.planned, options_.shots, counts.shots, static_cast<double>(counts.shots) / now_s,
               counts.violations);
  }

 private:
  const Options& options_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double shown_s_ = 0.0;
};

/// The jobs' tallies, summed as they come. False: a job died.
bool collect(int pipe_end, const Options& options, Progress& progress, SoakCounts& sum) {
  for (SoakCounts part;;) {
    const ssize_t got = read(pipe_end, &part, sizeof part);  // a write this short is not torn
    if (got != sizeof part) break;
    sum.add(part);
    progress.show(sum);
  }
  bool well = true;
  for (int job = 0; job < options.jobs; ++job) {
    int status = 0;
    well = wait(&status) > 0 && WIFEXITED(status) && WEXITSTATUS(status) == kDone && well;
  }
  return well;
}

int run(const Options& options, const Work& work) {
  int ends[2] = {-1, -1};
  if (pipe(ends) != 0) return bad_input("no pipe can be had");
  static_assert(sizeof(SoakCounts) <= 4096, "PIPE_BUF: longer writes of several processes mix");
  std::fflush(nullptr);
  Progress progress(options);
  for (int job = 0; job < options.jobs; ++job) {
    if (fork() != 0) continue;
    close(ends[0]);
    run_share(options, work, job, ends[1]);
    std::fflush(nullptr);
    _exit(kDone);
  }
  close(ends[1]);
  SoakCounts sum;
  const bool well = collect(ends[0], options, progress, sum);
  const double seconds = progress.elapsed_s();
  fmt::print("{}{:<44} {:>14.1f}\n{:<44} {:>14.0f}\n", table_of(sum), "seconds", seconds,
             "shots a second, all jobs", static_cast<double>(sum.shots) / seconds);
  if (!well) fmt::print(stderr, "strobe-soak: a process of the soak died\n");
  return well && sum.violations == 0 ? kDone : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Soak of the whole system on a virtual clock: firmware, rig, bus and host in one process");
  app.add_option("--shots", options.shots, "shots that must count (default 10000), ten a run")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}));
  app.add_option("--from", options.from, "skip this many shots first (default 0)")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1'000'000'000}));
  app.add_option("--seed", options.seed, "of everything that is drawn (default 1)");
  app.add_option("--faults", options.faults, "none, mild, wild (default), stops or a file of probabilities");
  app.add_option("--plan", options.plan, "shipped, brief, gated, coded, mixed (default) or extremes");
  app.add_option("--rig", options.rig, "rig file (default: the shipped one)");
  app.add_option("--jobs", options.jobs, "processes (default 1); the result does not depend on them")
      ->check(CLI::Range(1, 64));
  app.add_flag("--trace", options.trace, "print what happens");
  app.add_flag("--quiet", options.quiet, "no progress");
  app.footer(
      "Example: strobe-soak --shots 100000 --seed 7 --faults wild --jobs 2\n"
      "Exit status: 0 nothing was violated, 1 something was, 2 bad usage or input.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadInput;
  }
  if (options.trace) options.jobs = 1;
  auto files = read_rig_files(options.rig);
  if (!files) return bad_input(files.error().message);
  auto faults = find_fault_plan(options.faults);
  if (!faults) return bad_input(faults.error().message);
  const auto plan = find_plan_kind(options.plan);
  if (!plan) return bad_input(plan.error().message);
  return run(options, {std::move(*files), std::move(*faults), *plan});
}
