// strobe-score: programs that find balls on strobe photographs, held against annotated ones.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "common/config/files.hpp"
#include "host/external/program.hpp"
#include "tests/real/report.hpp"

namespace {

using namespace strobe;
using namespace strobe::real;

struct Options {
  std::vector<std::string> folders, alterations;
  std::string program, strobe, finder = "strobe", only, leaderboard, write;
  bool as_is = false, no_curved = false, every_scale = false, why = false, json = false;
  double tolerance_percent = 12.0, scale_off_percent = 10.0;
  int jobs = 1;
};

int refuse(const std::string& why) {
  fmt::print(stderr, "strobe-score: {}\n", why);
  return 2;
}

Result<std::vector<Photograph>> photographs_of(const Options& options) {
  std::vector<Photograph> all;
  for (const std::string& folder : options.folders) {
    const auto some = load_collection(folder);
    if (!some) return some;
    for (const Photograph& photograph : *some)
      if (photograph.file.find(options.only) != std::string::npos &&
          !(options.no_curved && photograph.curved))
        all.push_back(photograph);
  }
  if (all.empty()) return fail("no photographs");
  return all;
}

std::vector<const Alteration*> alterations_of(const Options& options) {
  std::vector<const Alteration*> all;
  for (const Alteration& alteration : alterations())
    if (&alteration == &alterations().front() ||
        (!options.as_is &&
         (options.alterations.empty() || std::ranges::count(options.alterations, alteration.name))))
      all.push_back(&alteration);
  return all;
}

std::atomic<bool> stopped = false;

/// The altered photographs lie in a folder that a signal's default action would leave behind.
void stop_in_good_order() {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stopped = true; });
}

/// At most one line every five seconds.
void show_progress(std::size_t done, std::size_t count) {
  static auto shown = std::chrono::steady_clock::now();
  const auto now = std::chrono::steady_clock::now();
  if (now - shown < std::chrono::seconds(5)) return;
  shown = now;
  fmt::print(stderr, "strobe-score: {} of {}\n", done, count);
}

/// As they are at each scale; altered at the right one, unless all are wanted.
Result<std::vector<Outcome>> measured(const std::vector<Photograph>& photographs, const Finder& finder,
                                      const Options& options) {
  auto altered = alterations_of(options);
  const std::vector as_they_are{altered.front()};
  altered.erase(altered.begin());
  std::vector<double> told{1.0};
  if (const double off = 0.01 * options.scale_off_percent; off > 0.0)
    told.insert(told.end(), {1.0 + off, 1.0 - off});
  Asked asked{as_they_are, told, options.tolerance_percent, options.jobs, &stopped};
  auto outcomes = evaluated(photographs, finder, asked, show_progress);
  if (!outcomes) return outcomes;
  asked.alterations = altered;
  if (!options.every_scale) asked.told = {1.0};
  const auto more = evaluated(photographs, finder, asked, show_progress);
  if (!more) return more;
  outcomes->insert(outcomes->end(), more->begin(), more->end());
  return outcomes;
}

Result<NamedFinder> finder_named(const std::string& name, const std::vector<Photograph>& photographs,
                                 const Options& options) {
  if (!options.program.empty() && name == "strobe")
    return NamedFinder{options.program, finder_of(options.program)};
  const Asked asked{{}, {}, options.tolerance_percent, options.jobs, &stopped};
  if (name == "hough") return best_of(hough_finders(), photographs, asked);
  if (name == "blob") return best_of(blob_finders(), photographs, asked);
  const auto strobe = options.strobe.empty() ? external::find_own_program("strobe") : options.strobe;
  if (!strobe) return fail("there is no strobe beside this program; name it with --strobe");
  return NamedFinder{"`strobe digitize`", finder_of(digitize_command(std::filesystem::absolute(*strobe)))};
}

Result<void> write_leaderboard(const std::vector<Photograph>& photographs, const Options& options) {
  std::string text;
  if (!options.write.empty()) {
    const auto read = config::read_file(options.write);
    if (!read) return tl::unexpected(read.error());
    text = *read;
    // Before the work: it takes minutes.
    if (const auto place = with_leaderboard(text, options.leaderboard, ""); !place)
      return fail(options.write + ": " + place.error().message);
  }
  std::string table = leaderboard_head();
  for (const char* name : {"strobe", "hough", "blob"}) {
    const auto finder = finder_named(name, photographs, options);
    if (!finder) return tl::unexpected(finder.error());
    fmt::print(stderr, "strobe-score: {}\n", finder->name);
    const auto outcomes = measured(photographs, finder->find, options);
    if (!outcomes) return tl::unexpected(outcomes.error());
    table += leaderboard_row(finder->name, *outcomes);
  }
  fmt::print("{}", table);
  if (options.write.empty()) return {};
  return config::write_file(options.write, *with_leaderboard(text, options.leaderboard, table));
}

void add_options(CLI::App& app, Options& o) {
  app.add_option("folders", o.folders, "Folders of photographs, each with its truth.json")->required();
  app.add_option("--program", o.program,
                 "Command of another program: {file}, {ball_diameter_m}, {px_per_m} and {size_tolerance} are "
                 "replaced; it "
                 "prints {\"circles\": [{\"x\", \"y\", \"d\"}]}, px, y downwards");
  app.add_option("--strobe", o.strobe, "Another strobe than the one beside this program");
  app.add_option("--finder", o.finder, "Who is judged; hough, blob: OpenCV's, each at its best settings")
      ->check(CLI::IsMember({"strobe", "hough", "blob"}))
      ->capture_default_str();
  std::vector<std::string> names;
  for (const Alteration& alteration : alterations()) names.emplace_back(alteration.name);
  app.add_option("--alteration", o.alterations, "These alterations [all]")->check(CLI::IsMember(names));
  app.add_flag("--as-is", o.as_is, "No alterations");
  app.add_option("--only", o.only, "Photographs whose name contains this");
  app.add_flag("--no-curved", o.no_curved, "Without those whose path is no straight leg or two");
  app.add_option("--size-tolerance", o.tolerance_percent, "Of the balls' size, percent")
      ->check(CLI::Range(1.0, 50.0))
      ->capture_default_str();
  app.add_option("--scale-off", o.scale_off_percent,
                 "By so many percent too large and too small a scale is told, too")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  app.add_flag("--every-scale", o.every_scale, "Wrong scales with the alterations as well");
  app.add_flag("--why", o.why,
               "Each ball missed with what the program said of it, and each image that is none");
  app.add_flag("--json", o.json, "One JSON object per line");
  app.add_option("--leaderboard", o.leaderboard,
                 "Compare strobe, hough and blob: a table, its name in --write's file");
  app.add_option("--write", o.write, "Put that table into this Markdown file")->needs("--leaderboard");
  app.add_option("--jobs", o.jobs, "Photographs at once")->check(CLI::Range(1, 64))->capture_default_str();
}

int run(const Options& options) {
  cv::setNumThreads(1);  // photographs side by side, if anything
  const auto photographs = photographs_of(options);
  if (!photographs) return refuse(photographs.error().message);
  if (!options.leaderboard.empty()) {
    const auto done = write_leaderboard(*photographs, options);
    return done ? 0 : refuse(done.error().message);
  }
  const auto finder = finder_named(options.finder, *photographs, options);
  if (!finder) return refuse(finder.error().message);
  const auto outcomes = measured(*photographs, finder->find, options);
  if (!outcomes) return refuse(outcomes.error().message);
  const auto broken = breaches(*outcomes, {});
  if (options.json) {
    fmt::print("{}", json_lines(*outcomes, {}));
    return broken.empty() ? 0 : 1;
  }
  fmt::print("{}: {} photographs\n\n{}\n", finder->name, photographs->size(),
             tables(*outcomes, *photographs, options.why));
  for (const std::string& line : broken) fmt::print("does not hold: {}\n", line);
  if (broken.empty()) fmt::print("all bounds hold\n");
  return broken.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Programs that find balls on strobe photographs, held against annotated ones.\n"
      "Example: strobe-score tests/real/example --why"};
  app.name("strobe-score");
  command_line::set_help(app);
  app.footer("Exit status: 0 all bounds hold, 1 one does not, 2 bad usage or input.");
  add_options(app, options);
  try {
    app.parse(argc, argv);
    stop_in_good_order();
    return run(options);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "{}\n", command_line::complaint(app, error));
    return 2;
  } catch (const std::exception& error) {
    return refuse(error.what());
  }
}
