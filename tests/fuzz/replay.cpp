// Runs a fuzzing entry point without libFuzzer: the seeds in a folder, then so many mutations of them.
//   fuzz_replay NAME --corpus DIR [--mutations N] [--seed N] [--run I]   (--run: repeat one mutation alone)
//   fuzz_replay NAME FILE...                                             (repeat inputs that libFuzzer kept)
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "tests/fuzz/entry_points.hpp"
#include "tests/fuzz/mutate.hpp"

namespace {

struct Options {
  strobe::fuzz::EntryPoint entry_point = nullptr;
  std::string corpus;
  std::uint64_t mutations = 1000;
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> run;
  std::vector<std::string> files;
};

char now_running[512] = "";  // printed by the handler of a crash

void tell_what_crashed(int signal_number) {
  std::size_t length = 0;
  while (length < sizeof now_running && now_running[length] != '\0') ++length;
  const ssize_t ignored = write(STDERR_FILENO, now_running, length);
  static_cast<void>(ignored);
  std::signal(signal_number, SIG_DFL);
  std::raise(signal_number);
}

void run_input(const Options& options, const std::string& input) {
  options.entry_point(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

std::string contents(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void run_file(const Options& options, const std::filesystem::path& path) {
  std::snprintf(now_running, sizeof now_running, "crashed on %s\n", path.c_str());
  run_input(options, contents(path));
}

void run_mutation(const Options& options, const std::vector<std::string>& seeds, std::uint64_t run) {
  std::snprintf(now_running, sizeof now_running, "crashed; repeat with --corpus %s --seed %llu --run %llu\n",
                options.corpus.c_str(), static_cast<unsigned long long>(options.seed),
                static_cast<unsigned long long>(run));
  run_input(options, strobe::fuzz::mutated(seeds, options.seed, run));
}

Options parse(int argc, char** argv) {
  Options options;
  const auto named = strobe::fuzz::kEntryPoints.find(argc > 1 ? argv[1] : "");
  if (named != strobe::fuzz::kEntryPoints.end()) options.entry_point = named->second;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    const bool more = i + 1 < argc;
    if (word == "--corpus" && more)
      options.corpus = argv[++i];
    else if (word == "--mutations" && more)
      options.mutations = std::strtoull(argv[++i], nullptr, 10);
    else if (word == "--seed" && more)
      options.seed = std::strtoull(argv[++i], nullptr, 10);
    else if (word == "--run" && more)
      options.run = std::strtoull(argv[++i], nullptr, 10);
    else
      options.files.push_back(word);
  }
  return options;
}

int replay_corpus(const Options& options) {
  std::vector<std::filesystem::path> paths;
  if (std::filesystem::is_directory(options.corpus))
    for (const auto& entry : std::filesystem::directory_iterator(options.corpus))
      paths.push_back(entry.path());
  if (paths.empty()) {
    std::fprintf(stderr, "no seeds in %s\n", options.corpus.c_str());
    return EXIT_FAILURE;
  }
  std::sort(paths.begin(), paths.end());
  std::vector<std::string> seeds;
  for (const auto& path : paths) {
    seeds.push_back(contents(path));
    if (!options.run) run_file(options, path);
  }
  if (options.run) {
    run_mutation(options, seeds, *options.run);
    return EXIT_SUCCESS;
  }
  for (std::uint64_t run = 0; run < options.mutations; ++run) run_mutation(options, seeds, run);
  std::printf("%zu seeds and %llu mutations under seed %llu ran without a crash\n", seeds.size(),
              static_cast<unsigned long long>(options.mutations),
              static_cast<unsigned long long>(options.seed));
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = parse(argc, argv);
  for (const int signal_number : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS, SIGILL})
    std::signal(signal_number, tell_what_crashed);
  if (options.entry_point == nullptr || (options.corpus.empty() && options.files.empty())) {
    std::fprintf(stderr, "usage: %s NAME --corpus DIR [--mutations N] [--seed N] [--run I] | FILE...\n",
                 argv[0]);
    return 2;
  }
  for (const std::string& file : options.files) run_file(options, file);
  return options.corpus.empty() ? EXIT_SUCCESS : replay_corpus(options);
}
