// strobe-contradictions: shots with trouble of each kind, and how often the reduction gives a wrong number in silence.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>
#include <string>

#include "tests/contradictions/report.hpp"

using namespace strobe::contradictions;

namespace {

constexpr int kDone = 0, kBeyondLimit = 1;

struct Options {
  std::vector<std::string> kinds;
  std::int64_t shots = 20000;
  std::uint64_t seed = 1, write = 0;
  std::vector<std::string> noise{"hand"};
  std::string images = "2:40";
  double limit_percent = 0.2, limit_unprovable_percent = 2.0;
  bool json = false, coverage = false, noise_absent = false;
};

std::vector<Kind> chosen_kinds(const Options& options) {
  std::vector<Kind> kinds;
  for (const std::string& text : options.kinds) {
    const auto kind = kind_from_name(text);
    std::string known;
    for (const auto& k : kKinds) known += fmt::format("\n  {:<24} {}", k.name, k.what);
    if (!kind) throw CLI::ValidationError("--kind", fmt::format("no \"{}\" among{}", text, known));
    kinds.push_back(*kind);
  }
  for (std::size_t i = 0; i < kKindCount && options.kinds.empty(); ++i) kinds.push_back(static_cast<Kind>(i));
  return kinds;
}

Settings settings_of(const Options& options, const std::string& noise) {
  Settings settings;
  settings.noise = noise == "hand" ? NoiseLevel::hand : NoiseLevel::digitizer;
  settings.noise_stated = !options.noise_absent;
  char rest = 0;
  const int read =
      std::sscanf(options.images.c_str(), "%d:%d%c", &settings.least_images, &settings.most_images, &rest);
  const bool valid = read == 2 && settings.least_images >= 2 &&
                     settings.most_images >= settings.least_images && settings.most_images <= 1000;
  if (!valid) throw CLI::ValidationError("--images", "must be A:B, 2 <= A <= B <= 1000");
  return settings;
}

std::vector<Row> run_all(const Options& options, const std::string& noise) {
  std::vector<Row> rows;
  for (const Kind kind : chosen_kinds(options)) {
    Row row{{kind, settings_of(options, noise), options.seed, options.shots}, {}};
    row.tally = tallied(row.run);
    rows.push_back(std::move(row));
  }
  return rows;
}

void print(const std::vector<Row>& rows, const Options& options, const std::string& noise) {
  if (options.json) {
    for (const Row& row : rows) fmt::print("{}", json_line(row));
    return;
  }
  fmt::print("seed {}, {} noise, {} images a leg\n{}", options.seed, noise, options.images, table(rows));
  for (const Row& row : rows) {
    const bool undisturbed = row.run.kind == Kind::none || row.run.kind == Kind::air;
    if (undisturbed) fmt::print("\n{}", false_flags(row));
    if (undisturbed || options.coverage) fmt::print("\n{}", coverage_table(row));
  }
}

void write(const Options& options) {
  for (const std::string& noise : options.noise)
    for (const Kind kind : chosen_kinds(options))
      fmt::print("{}", shot_line(drawn_shot(kind, settings_of(options, noise), options.seed, options.write)));
}

int contradictions(const Options& options) {
  if (options.write > 0) {
    write(options);
    return kDone;
  }
  int status = kDone;
  for (const std::string& noise : options.noise) {
    const std::vector<Row> rows = run_all(options, noise);
    print(rows, options, noise);
    for (const auto& [run, tally] : rows)
      if (100.0 * tally.share(tally.silent) > options.limit_percent ||
          100.0 * tally.share(tally.unprovable) > options.limit_unprovable_percent)
        status = kBeyondLimit;
  }
  return status;
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--kind", options.kinds,
                 "of trouble; several, or all if not given. An unknown one lists them");
  app.add_option("--shots", options.shots, "of each kind")
      ->check(CLI::Range(1, 1000000000))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "repeats a run")->capture_default_str();
  app.add_option("--noise", options.noise,
                 "of the measurements, one or both: hand, 0.5-2 px and 0.7-2 degrees; digitizer, 0.05-0.1 px "
                 "and 0.1-0.3")
      ->check(CLI::IsMember({"hand", "digitizer"}))
      ->capture_default_str();
  app.add_option("--images", options.images, "least and most images of a leg")->capture_default_str();
  app.add_option("--limit", options.limit_percent, "silently wrong shots of a kind, in percent")
      ->capture_default_str();
  app.add_option("--limit-unprovable", options.limit_unprovable_percent,
                 "likewise, of trouble that a shot's data cannot prove")
      ->capture_default_str();
  app.add_option("--write", options.write, "print this shot of each kind as a frame in JSON, with its truth");
  app.add_flag("--noise-absent", options.noise_absent, "frames state no noise");
  app.add_flag("--coverage", options.coverage, "print each kind's coverage");
  app.add_flag("--json", options.json, "one object for each kind");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Draws shots with trouble of each kind and counts wrong numbers that no flag explains: beyond 6 stated "
      "sd and\n"
      "beyond a tenth of what digitizing by hand does. Status 1 if a kind has more of them than the limits.\n"
      "Example: strobe-contradictions --kind outlier_centre --shots 100000 --seed 7\n"
      "One of its shots, with its truth: strobe-contradictions --kind outlier_centre --seed 7 --write 123 | "
      "strobe "
      "reduce - --format frame");
  Options options;
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    return contradictions(options);
  } catch (const CLI::Error& error) {
    return app.exit(error);
  }
}
