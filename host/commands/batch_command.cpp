// strobe batch: the photographs of many sessions measured again, as when a calibration improves.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "common/data/csv.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/batch/batch_run.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/commands/command.hpp"
#include "host/commands/shared_options.hpp"
#include "host/session/record_file.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

struct BatchOptions {
  std::vector<std::string> sessions;
  std::string list, rig, calibration, out, shard;
  std::string effort = "standard";
  std::vector<std::string> merge;
  int jobs = 0;
  bool frames = false, json = false;
};

struct Shard {
  int number = 1, of = 1;
};

Result<Shard> shard_of(const std::string& text) {
  Shard shard;
  if (text.empty()) return shard;
  char end = 0;
  if (std::sscanf(text.c_str(), "%d/%d%c", &shard.number, &shard.of, &end) != 2 || shard.number < 1 ||
      shard.of < shard.number || shard.of > 1'000'000)
    return fail("--shard " + text + ": must be I/N with I from 1 to N, such as 3/8");
  return shard;
}

/// One path a line; empty lines and those that begin with # are skipped.
Result<std::vector<std::string>> listed(const BatchOptions& options) {
  std::vector<std::string> paths = options.sessions;
  if (options.list.empty()) return paths;
  std::ifstream file;
  if (options.list != "-") file.open(options.list);
  std::istream& lines = options.list == "-" ? std::cin : file;
  if (!lines) return fail(options.list + ": cannot be read");
  for (std::string line; std::getline(lines, line);) {
    if (line.ends_with('\r')) line.pop_back();
    if (!line.empty() && line.front() != '#') paths.push_back(line);
  }
  if (lines.bad()) return fail(options.list + ": cannot be read");
  return paths;
}

std::int64_t photographs_in(const std::vector<BatchSession>& sessions) {
  std::int64_t count = 0;
  for (const BatchSession& session : sessions) {
    std::error_code error;
    for (fs::directory_iterator entry(fs::path(session.path) / "photographs", error), end;
         !error && entry != end; entry.increment(error))
      ++count;
  }
  return count;
}

/// "3 h 5 min", "40 s"
std::string duration_text(double seconds) {
  const auto whole = static_cast<std::int64_t>(seconds + 0.5);
  if (whole < 90) return fmt::format("{} s", whole);
  if (whole < 5400) return fmt::format("{} min", (whole + 30) / 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

/// The row's cells by their columns; those of numbers as numbers, absent ones null.
std::string finished_row_json(const FinishedRow& row) {
  const auto columns = batch_columns();
  const auto cells = data::csv_cells(row.line);
  nlohmann::ordered_json object;
  for (std::size_t i = 0; i < columns.size() && i < cells.size(); ++i) {
    nlohmann::ordered_json& value = object[columns[i].name];
    const bool text = columns[i].datatype == "string" || columns[i].datatype == "dateTime";
    if (text)
      value = cells[i];
    else if (!cells[i].empty())
      value = messages::parsed_json<nlohmann::ordered_json>(cells[i]);
  }
  return messages::json_text(object);
}

/// A line in five seconds on standard error.
class ProgressTeller {
 public:
  ProgressTeller(std::int64_t photographs, bool json) : photographs_(photographs), json_(json) {}

  void operator()(const FinishedRow& row, const BatchProgress& progress) {
    if (json_ && !row.earlier) std::puts(finished_row_json(row).c_str());
    const HostTime now = steady_now();
    if (now - reported_ < std::chrono::seconds{5}) return;
    reported_ = now;
    const double elapsed_s = to_seconds(now - start_);
    const double rate = static_cast<double>(progress.measured) / elapsed_s;
    const auto left = std::max<std::int64_t>(0, photographs_ - progress.rows);
    fmt::print(stderr, "strobe: {} of {} photographs, {:.1f} a second{}\n", progress.rows, photographs_, rate,
               rate > 0.0 ? ", " + duration_text(static_cast<double>(left) / rate) + " left" : "");
  }

 private:
  std::int64_t photographs_;
  bool json_;
  HostTime start_ = steady_now();
  HostTime reported_ = start_;
};

std::atomic<BatchRun*> running = nullptr;

/// The first stops after the photographs under way; all that is finished is stored anyway, so the next may
/// end it at once.
void on_signal(int number) {
  if (BatchRun* run = running) run->stop();
  std::signal(number, SIG_DFL);
}

std::string end_json(const BatchProgress& progress, bool stopped) {
  nlohmann::ordered_json object;
  object["finished"] = progress.rows;
  object["measured"] = progress.measured;
  object["failed"] = progress.failed;
  object["sessions"] = progress.sessions;
  object["unread_sessions"] = progress.unread_sessions;
  object["sessions_with_remarks"] = progress.sessions_with_remarks;
  object["stopped"] = stopped;
  return messages::json_text(object);
}

void print_end(const BatchOptions& options, const BatchProgress& progress, std::optional<int> merged) {
  const fs::path out = options.out;
  fmt::print("{} shots of {} sessions, {} of them measured now; {} photographs failed\n", progress.rows,
             progress.sessions, progress.measured, progress.failed);
  if (progress.sessions_with_remarks > 0)
    fmt::print("remarks on {} sessions: {}\n", progress.sessions_with_remarks,
               (out / "*.remarks.txt").string());
  if (merged) fmt::print("{}: {} rows\n", (out / "results.csv").string(), *merged);
}

int tell_end(const BatchOptions& options, const BatchProgress& progress, bool stopped,
             std::optional<int> merged) {
  if (options.json)
    std::puts(end_json(progress, stopped).c_str());
  else
    print_end(options, progress, merged);
  if (stopped) return failed("batch: stopped; what is finished is stored, the same command goes on");
  if (progress.unread_sessions > 0)
    return failed(
        fmt::format("batch: {} sessions cannot be read; their rows say why", progress.unread_sessions));
  return progress.failed > 0 ? kFailed : kDone;
}

int run_merge(const BatchOptions& options) {
  const std::vector<fs::path> folders(options.merge.begin(), options.merge.end());
  const fs::path out = options.out.empty() ? folders.front() : fs::path(options.out);
  std::error_code error;
  fs::create_directories(out, error);
  const auto rows = merge_tables(folders, out);
  if (!rows) return bad_input("batch: " + rows.error().message);
  if (options.json)
    fmt::print("{{\"rows\":{}}}\n", *rows);
  else
    fmt::print("{}: {} rows\n", (out / "results.csv").string(), *rows);
  return kDone;
}

Result<BatchSettings> settings_of(const BatchOptions& options) {
  BatchSettings settings;
  settings.version = STROBE_VERSION;
  settings.rig = options.rig;
  settings.effort = digitize::effort_from_name(options.effort).value();
  settings.stored_frames = options.frames;
  if (!options.calibration.empty()) {
    auto text = read_option_file("--calibration", options.calibration);
    if (!text) return tl::unexpected(text.error());
    settings.calibration_text = std::move(*text);
    settings.calibration_name = options.calibration;
  }
  return settings;
}

/// Also tries the batch's rig file and calibration, so that what is wrong with them is told once.
Result<std::string> id_of(const BatchSettings& settings) {
  RigFile rig;
  if (!settings.rig.empty()) {
    auto loaded = load_rig(settings.rig);
    if (!loaded) return tl::unexpected(loaded.error());
    rig = std::move(*loaded);
  }
  if (auto tried = calibrated(rig, settings); !tried) return tl::unexpected(tried.error());
  return batch_id(settings, rig.text + rig.calibration_text + rig.ball_text);
}

Result<int> run(const BatchOptions& options) {
  const auto shard = shard_of(options.shard);
  if (!shard) return tl::unexpected(shard.error());
  const auto paths = listed(options);
  if (!paths) return tl::unexpected(paths.error());
  if (paths->empty()) return fail("no session is given");
  const auto settings = settings_of(options);
  if (!settings) return tl::unexpected(settings.error());
  const auto id = id_of(*settings);
  if (!id) return tl::unexpected(id.error());
  const auto all = batch_sessions(*paths);
  std::vector<BatchSession> own;
  BatchManifest manifest{*id, {}};
  for (std::size_t i = 0; i < all.size(); ++i) {
    manifest.sessions.push_back(all[i].name);
    if (static_cast<int>(i % static_cast<std::size_t>(shard->of)) + 1 == shard->number) own.push_back(all[i]);
  }
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error) return fail(options.out + ": " + error.message());
  if (auto written = write_manifest(options.out, manifest); !written) return tl::unexpected(written.error());
  const bool whole = shard->of == 1;
  auto journal = BatchJournal::open(
      options.out, whole ? "done.jsonl" : fmt::format("done-{}-of-{}.jsonl", shard->number, shard->of));
  if (!journal) return tl::unexpected(journal.error());
  ProgressTeller teller(photographs_in(own), options.json);
  BatchRun batch(*settings, *id, options.out, **journal, std::ref(teller));
  running = &batch;
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, on_signal);
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const auto done = batch.run(own, options.jobs > 0 ? options.jobs : cores);
  running = nullptr;
  if (!done) return failed("batch: " + done.error().message);
  std::optional<int> merged;
  if (whole && !batch.stopped()) {
    const auto rows = merge_tables({options.out}, options.out);
    if (!rows) return failed("batch: " + rows.error().message);
    merged = *rows;
  }
  return tell_end(options, *done, batch.stopped(), merged);
}

int run_batch(const BatchOptions& options) {
  if (!options.merge.empty()) return run_merge(options);
  if (options.out.empty()) return bad_input("batch: --out is required");
  if (options.frames && !options.calibration.empty())
    return bad_input(
        "batch: --frames keeps the calibration that the frames were digitized with; leave --calibration out");
  const auto status = run(options);
  return status ? *status : bad_input("batch: " + status.error().message);
}

}  // namespace

void add_batch_command(CLI::App& app, int& exit_status) {
  auto options = std::make_shared<BatchOptions>();
  CLI::App* command = app.add_subcommand("batch", "Measure the photographs of many sessions again");
  command->add_option("SESSION", options->sessions, "folders of sessions");
  command->add_option("--list", options->list,
                      "file that names a session's folder a line; -: standard input");
  command->add_option("--out", options->out,
                      "folder for the results, made if need be; what it has is not done again");
  command->add_option("--rig", options->rig, "rig file (default: the one that each session keeps)");
  command->add_option("--calibration", options->calibration, "the camera's, in place of the rig file's");
  command->add_option("--effort", options->effort, "fast, standard or thorough")
      ->check(CLI::IsMember({"fast", "standard", "thorough"}))
      ->capture_default_str();
  command->add_flag("--frames", options->frames, "only reduce what was digitized; no photograph is measured");
  command->add_option("--jobs", options->jobs, "photographs at once (default: this computer's cores)")
      ->check(CLI::Range(1, 4096));
  command->add_option("--shard", options->shard,
                      "I/N: only this part of the sessions, on one of several computers");
  command->add_option("--merge", options->merge, "folders of finished parts: make one results.csv of them");
  command->add_flag("--json", options->json, "one JSON object per photograph measured, and one at the end");
  command->footer(
      "Examples: strobe batch sessions/* --calibration camera.toml --out again\n"
      "          parallel strobe batch --list all.txt --out again --jobs 1 --shard {}/8 ::: 1 2 3 4 5 6 7 8\n"
      "          strobe batch --merge again\n"
      "Exit status: 1 if it was stopped, or a photograph or session failed: its row says why.");
  command->callback([options, &exit_status] { exit_status = run_batch(*options); });
}

}  // namespace strobe::host
