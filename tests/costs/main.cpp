// strobe-costs: instructions of each case, compared with tests/costs/costs.json. Exit status: 0 within the record;
// 1 something grew, or could not be counted; 2 bad usage; 77 nothing is recorded for this machine and compiler.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <opencv2/core/utility.hpp>

#include "tests/costs/cases.hpp"
#include "tests/costs/counts.hpp"

using namespace strobe::costs;

/// callgrind collects while this runs, and writes what it collected when this returns.
extern "C" [[gnu::noinline]] void strobe_costs_counted(const Case& counted) { counted.run(); }

namespace {

constexpr int kDone = 0, kFailed = 1, kNoRecord = 77;

using Json = nlohmann::ordered_json;

int run_all() try {
  cv::setNumThreads(1);  // callgrind collects of the calling thread only
  for (const Case& each : all_cases()) {
    each.run();
    strobe_costs_counted(each);
  }
  return kDone;
} catch (const std::exception& error) {
  fmt::print(stderr, "strobe-costs: {}\n", error.what());
  return kFailed;
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const Case& each : all_cases()) all.push_back(each.name);
  return all;
}

Json read_record() {
  std::ifstream file(STROBE_SOURCE_DIR "/tests/costs/costs.json");
  return Json::parse(file);
}

int failed(const std::string& why) {
  fmt::print(stderr, "strobe-costs: {}\n", why);
  return kFailed;
}

int check() {
  const Json record = read_record();
  if (!record.contains(build())) {
    fmt::print("SKIPPED: no counts are recorded for {}; tests/costs/record does\n", build());
    return kNoRecord;
  }
  const auto counted = count(names());
  if (!counted) return failed(counted.error().message);
  const Counts recorded = record[build()].get<Counts>();
  for (const auto& [name, count] : *counted) {
    const auto before = recorded.find(name);
    if (before == recorded.end()) continue;
    fmt::print("{:<28} {:>12} recorded {:>12} {:+6.1f} %\n", name, count, before->second,
               100.0 * (static_cast<double>(count) / static_cast<double>(before->second) - 1.0));
  }
  const auto lines = complaints(recorded, *counted);
  for (const std::string& line : lines) fmt::print(stderr, "strobe-costs: {}\n", line);
  return lines.empty() ? kDone : kFailed;
}

int store() {
  const auto counted = count(names());
  if (!counted) return failed(counted.error().message);
  Json record = read_record();
  record[build()] = *counted;
  std::ofstream(STROBE_SOURCE_DIR "/tests/costs/costs.json") << record.dump(2) << '\n';
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Instruction counts of the costly parts, compared with their record."};
  app.name("strobe-costs");
  app.require_subcommand(1);
  int status = kDone;
  app.add_subcommand("check", "Count, and compare with the record")->callback([&] { status = check(); });
  app.add_subcommand("record", "Count, and store the counts as the record")->callback([&] {
    status = store();
  });
  app.add_subcommand("run", "Run every case twice (under callgrind)")->callback([&] { status = run_all(); });
  CLI11_PARSE(app, argc, argv);
  return status;
}
