// strobe-figures: the figures that READMEs state. `check` compares record and READMEs, `write` generates their tables
// anew, `measure` runs the commands and shows what moved. Exit status: 0 all agree; 1 something differs, or a
// command failed; 2 bad usage, or a record that cannot be read.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/figures/record.hpp"

namespace {

using namespace strobe;
using namespace strobe::figures;
namespace fs = std::filesystem;

constexpr int kSame = 0, kDiffers = 1, kBadInput = 2;

struct Options {
  fs::path root = STROBE_SOURCE_DIR;
  std::vector<std::string> names;
  bool update = false;
  std::string machine;
  fs::path record() const { return root / "tests/figures/figures.json"; }
};

int bad_input(const std::string& why) {
  fmt::print(stderr, "strobe-figures: {}\n", why);
  return kBadInput;
}

std::string read(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::vector<fs::path> readmes(const fs::path& root) {
  std::vector<fs::path> found{root / "README.md"};
  for (const char* folder : {"common", "firmware", "host", "sim", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / folder))
      if (entry.path().filename() == "README.md") found.push_back(entry.path());
  }
  return found;
}

/// Compares every README with what the record generates, and writes it anew where that is asked for.
int generate(const Options& options, bool write) {
  const auto record = load(options.record());
  if (!record) return bad_input(record.error().message);
  int status = kSame;
  for (const fs::path& readme : readmes(options.root)) {
    const std::string before = read(readme);
    const auto after = regenerated(before, *record);
    if (!after) return bad_input(readme.string() + ": " + after.error().message);
    if (*after == before) continue;
    if (write) {
      std::ofstream(readme) << *after;
      fmt::print("written: {}\n", readme.string());
    } else {
      fmt::print(stderr, "{} does not agree with figures.json: run strobe-figures write\n", readme.string());
      status = kDiffers;
    }
  }
  return status;
}

/// Standard output and error of a command line. Returns nullopt if it did not end with status 0.
std::optional<std::string> output_of(const std::string& command) {
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return std::nullopt;
  std::string output;
  std::array<char, 4096> part{};
  while (const std::size_t count = std::fread(part.data(), 1, part.size(), pipe))
    output.append(part.data(), count);
  if (pclose(pipe) != 0) return std::nullopt;
  return output;
}

const char* in_words(Change change) {
  switch (change) {
    case Change::same:
      return "same";
    case Change::moved:
      return "BETTER";
    case Change::worse:
      return "WORSE";
  }
  return "";
}

std::string today() {
  const auto day = std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now());
  const std::chrono::year_month_day date(day);
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

/// Counts without a decimal point.
Json json_number(double x) {
  const auto whole = static_cast<std::int64_t>(x);
  return static_cast<double>(whole) == x ? Json(whole) : Json(x);
}

/// Measures one figure, prints each of its values, and stores them in the record where that is asked for.
int measure_one(const std::string& name, Json& figure, const Options& options) {
  const std::string command = figure["command"];
  fmt::print(stderr, "measuring {}: {}\n", name, command);
  const auto output = output_of(command);
  if (!output) {
    fmt::print("{:<44} FAILED: {}\n", name, command);
    return kDiffers;
  }
  int status = kSame;
  bool is_complete = true;
  for (auto& [value_name, value] : figure["values"].items()) {
    const std::string label = name + "." + value_name;
    const double recorded = value["value"];
    const auto measured = found_in(*output, value);
    if (!measured) {
      fmt::print("{:<44} {:>12}   not found in the output\n", label, recorded);
      is_complete = false;
      status = kDiffers;
      continue;
    }
    const Change change = compare(recorded, *measured, value);
    fmt::print("{:<44} {:>12} -> {:>12}   {}\n", label, recorded, *measured, in_words(change));
    if (change != Change::same) status = kDiffers;
    if (options.update) value["value"] = json_number(*measured);
  }
  if (options.update && is_complete) {
    figure["measured"] = today();
    if (!options.machine.empty()) figure["machine"] = options.machine;
  }
  return status;
}

int measure(const Options& options) {
  auto record = load(options.record());
  if (!record) return bad_input(record.error().message);
  fs::current_path(options.root);
  const std::string path = (fs::path(STROBE_BUILD_DIR) / "bin").string() + ":" + std::getenv("PATH");
  setenv("PATH", path.c_str(), 1);
  std::vector<std::string> names = options.names;
  if (names.empty())
    for (const auto& [name, figure] : (*record)["figures"].items()) names.push_back(name);
  int status = kSame;
  for (const std::string& name : names) {
    if (!(*record)["figures"].contains(name)) return bad_input("no figure is named " + name);
    status = std::max(status, measure_one(name, (*record)["figures"][name], options));
    // After each, since all together take long.
    if (options.update) std::ofstream(options.record()) << record->dump(2) << '\n';
  }
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Measured figures of the READMEs: the record is tests/figures/figures.json."};
  app.name("strobe-figures");
  app.require_subcommand(1);
  Options options;
  int status = kSame;
  app.add_option("--root", options.root, "Folder of the repository")->capture_default_str();
  app.add_subcommand("check", "Do all READMEs agree with the record?")->callback([&] {
    status = generate(options, false);
  });
  app.add_subcommand("write", "Generate the READMEs' tables from the record")->callback([&] {
    status = generate(options, true);
  });
  CLI::App* measuring = app.add_subcommand("measure", "Run the figures' commands and show what moved");
  measuring->add_option("names", options.names, "Figures (default: all, which takes an hour)");
  measuring->add_flag("--update", options.update, "Store the values with today's date");
  measuring->add_option("--machine", options.machine, "With --update: what kind of machine this is");
  measuring->callback([&] { status = measure(options); });
  CLI11_PARSE(app, argc, argv);
  return status;
}
