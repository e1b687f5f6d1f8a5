#include "tests/benchmarks/timing/study.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <thread>

#include "tests/support/temporary_folder.hpp"

namespace strobe::benchmarks::timing {
namespace {

constexpr std::size_t kBytes = std::size_t{64} << 20;
constexpr std::size_t kBlock = std::size_t{1} << 20;

// Each runs for ever in a forked child: system calls and plain arithmetic only.
[[noreturn]] void compute() {
  volatile std::uint64_t state = 1;
  for (;;) state = state * 6364136223846793005ULL + 1442695040888963407ULL;
}

char* pages(std::size_t bytes) {
  void* memory =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (memory == MAP_FAILED) _exit(1);
  return static_cast<char*>(memory);
}

[[noreturn]] void copy_memory() {
  char* memory = pages(2 * kBytes);
  for (unsigned char round = 0;; ++round) {
    memory[round] = static_cast<char>(round);
    std::memcpy(memory + kBytes, memory, kBytes);
    std::memcpy(memory, memory + kBytes, kBytes);
  }
}

[[noreturn]] void write_disk(const char* path) {
  const char* block = pages(kBlock);
  const int file = open(path, O_CREAT | O_WRONLY | O_TRUNC | O_CLOEXEC, 0600);
  for (;;) {
    for (std::size_t done = 0; done < kBytes; done += kBlock)
      if (write(file, block, kBlock) < 0) _exit(1);
    if (fdatasync(file) != 0 || lseek(file, 0, SEEK_SET) != 0) _exit(1);
  }
}

}  // namespace

void add_study_options(CLI::App& command, StudyOptions& options) {
  command.add_option("--rounds", options.rounds, "rounds of everything in turn, for each load")
      ->check(CLI::Range(1, 1000));
  command.add_option("--seconds", options.loop.seconds, "length of each part")->check(CLI::Range(1, 3600));
  command.add_option("--priority", options.loop.priority, "real-time priority of what is measured")
      ->check(CLI::Range(11, 98));
  command.add_option("--cpu", options.loop.cpu, "CPU of what is measured; -1: any")
      ->check(CLI::Range(-1, 1023));
  command
      .add_option("--loads", options.loads, "idle, cpu (both cores busy), memory (and disk); all by default")
      ->delimiter(',')
      ->check(CLI::IsMember(kLoads));
  command.add_flag("--json", options.json, "one JSON object per row");
  command.add_option("--csv", options.csv, "write the rows to this file");
  command.add_option("--plot", options.plot, "draw into this SVG, with its numbers beside it (.csv)");
}

LoadRun under_load(const std::string& load, const StudyOptions& options, const std::filesystem::path& folder,
                   const std::function<void(int round)>& once) {
  FreezeDetector detector(options.loop.priority - 10, FreezeDetector::Method::interrupts);
  const Load running(load, folder);
  for (int round = 1; round <= options.rounds; ++round) {
    std::fprintf(stderr, "%s, round %d of %d\n", load.c_str(), round, options.rounds);
    once(round);
  }
  std::vector<Freeze> freezes = detector.stop();
  std::string words = freezes_in_words(freezes, detector.by());
  return {std::move(freezes), std::move(words), detector.interrupts()};
}

std::vector<Row> run_study(
    const StudyOptions& options,
    const std::function<LoadFigures(const std::string& load, const std::filesystem::path& folder)>& study) {
  const testing::TemporaryFolder folder;
  std::vector<Row> rows;
  std::vector<Panel> panels;
  for (const std::string& load : options.loads) {
    LoadFigures figures = study(load, folder.path());
    if (!options.json && !figures.words.empty()) std::printf("%s\n", figures.words.c_str());
    rows.insert(rows.end(), figures.rows.begin(), figures.rows.end());
    panels.push_back(std::move(figures.panel));
  }
  print_rows(rows, options.json);
  if (!options.csv.empty()) write_csv(options.csv, rows);
  if (!options.plot.empty()) draw(options.plot, panels);
  return rows;
}

template <typename Work>
void Load::start(Work work) {
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    work();
  }
  if (child > 0) processes_.push_back(child);
}

Load::Load(const std::string& kind, const std::filesystem::path& folder) : file_(folder / "load.bin") {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  for (unsigned core = 0; core < cores; ++core) {
    if (kind == "cpu") start(compute);
    if (kind == "memory") start(copy_memory);
  }
  const std::string path = file_;
  if (kind == "memory") start([&path] { write_disk(path.c_str()); });
}

Load::~Load() {
  for (const pid_t process : processes_) kill(process, SIGKILL);
  for (const pid_t process : processes_) waitpid(process, nullptr, 0);
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

}  // namespace strobe::benchmarks::timing
