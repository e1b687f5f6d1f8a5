#include "host/session/session_folder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <new>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>

#include "common/config/files.hpp"
#include "common/data/csv.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

/// name.toml, or name-<utc>.toml where an earlier run in this folder used another one. Returns which.
Result<std::string> keep(const fs::path& path, std::string_view text, const std::string& utc) {
  std::error_code error;
  const fs::path other = path.parent_path() / (path.stem().string() + "-" + utc + ".toml");
  const bool free = !fs::exists(path, error);
  if (!free && config::read_file(path.string()) == text) return path.filename().string();
  const fs::path& chosen = free ? path : other;
  if (auto written = config::write_file(chosen, text); !written) return tl::unexpected(written.error());
  return chosen.filename().string();
}

/// Beside the table, again where another version wrote it.
Result<void> describe(const fs::path& table, std::string_view title, std::span<const Column> columns) {
  const fs::path path = table.string() + "-metadata.json";
  const std::string text = data_dictionary(table.filename().string(), title, columns);
  std::error_code error;
  if (fs::exists(path, error) && config::read_file(path.string()) == text) return {};
  return config::write_file(path, text);
}

/// Whether what the file holds has no line's end.
bool ends_torn(int fd) {
  const off_t size = ::lseek(fd, 0, SEEK_END);
  char last = '\n';
  return size > 0 && ::pread(fd, &last, 1, size - 1) == 1 && last != '\n';
}

/// "2 FRAME, 1 READOUT"
std::string listed(const std::map<std::string, int>& kinds) {
  std::string text;
  for (const auto& [kind, count] : kinds)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, kind);
  return text;
}

}  // namespace

std::string utc_for_file(WallTime wall) { return fmt::format("{:%Y%m%dT%H%M%SZ}", fmt::gmtime(wall)); }

std::string utc_for_table(WallTime wall) {
  const auto ms = std::chrono::floor<milliseconds>(wall).time_since_epoch().count();
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(wall), ms % 1000);
}

Result<std::unique_ptr<SessionFolder>> SessionFolder::open(const fs::path& folder, const std::string& utc,
                                                           std::string_view rig_text,
                                                           std::string_view plan_text,
                                                           const KeptFile& calibration,
                                                           const KeptFile& ball) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": " + error.message());
  std::string plan_file;
  for (const auto& [name, text] :
       {KeptFile{"rig.toml", rig_text}, KeptFile{"plan.toml", plan_text}, calibration, ball}) {
    if (name.empty()) continue;
    auto kept = keep(folder / name, text, utc);
    if (!kept) return tl::unexpected(kept.error());
    if (name == "plan.toml") plan_file = std::move(*kept);
  }
  auto results = ResultsCsv::open(folder / "results.csv");
  if (!results) return tl::unexpected(results.error());
  auto flashes = FlashesCsv::open(folder / "flashes.csv");
  if (!flashes) return tl::unexpected(flashes.error());
  const auto& columns = results_columns();
  if (auto told = describe(folder / "results.csv", kResultsTitle,
                           std::span(columns).first(columns.size() - results->left_out()));
      !told)
    return tl::unexpected(told.error());
  if (auto told = describe(folder / "flashes.csv", "Flashes, one row each", flashes_columns()); !told)
    return tl::unexpected(told.error());
  auto words = RecordFile::open(folder / "shots.txt", RecordFile::Use::append);
  if (!words) return tl::unexpected(words.error());
  auto log = EventLog::create(folder, utc);
  if (!log) return tl::unexpected(log.error());
  if (!config::sync_folder(folder))
    return fail(folder.string() + ": cannot be written: " + std::strerror(errno));
  return std::unique_ptr<SessionFolder>(new SessionFolder(folder, std::move(plan_file), std::move(*log),
                                                          std::move(*results), std::move(*flashes),
                                                          std::move(*words)));
}

void SessionFolder::note(const Result<void>& done) {
  if (!done && reported_.insert(done.error().message).second) failures_.push_back(done.error().message);
}

void SessionFolder::log(const std::string& channel, std::span<const std::uint8_t> message, WallTime wall) {
  note(log_.append(channel, message, wall));
}

void SessionFolder::add(const Shot& shot, const std::string& utc) try {
  Shot told = shot;
  told.utc = utc;
  note(results_.add(std::move(told)));
} catch (const std::bad_alloc&) {
  lost_for_want_of_memory(results_.file().path(), shot.shot_id);
}

void SessionFolder::add(const strobe_msgs::shot_t& shot) try {
  note(flashes_.add(shot));
} catch (const std::bad_alloc&) {
  lost_for_want_of_memory(flashes_.file().path(), shot.shot_id);
}

void SessionFolder::add_text(const std::string& lines) try {
  note(text_.append(lines, "note"));
} catch (const std::bad_alloc&) {
  doubts_[text_.path()] =
      fmt::format("{}: a note is not stored: there is not enough memory", text_.path().string());
  note(fail(doubts_[text_.path()]));
}

void SessionFolder::add(const RunRecord& run) { append_line("runs.jsonl", run_line(run), "run"); }

void SessionFolder::add_camera(std::string_view object, const std::string& utc) {
  append_line("camera.jsonl", fmt::format("{{\"utc\":\"{}\",{}\n", utc, object.substr(1)),
              "camera's settings");
}

/// A line that a power cut tore is ended first.
void SessionFolder::append_line(const char* name, const std::string& line, const char* kind) {
  const fs::path path = folder_ / name;
  auto file = RecordFile::open(path, RecordFile::Use::append);
  Result<void> done = file ? file->append((ends_torn(file->fd()) ? "\n" : "") + line, kind)
                           : Result<void>(tl::unexpected(file.error()));
  if (done) done = file->close();
  if (done && !config::sync_folder(folder_))
    done = fail(path.string() + ": cannot be written: " + std::strerror(errno));
  note(done);
  if (!done) doubts_[path] = done.error().message;
}

void SessionFolder::lost_for_want_of_memory(const fs::path& path, int shot_id) {
  doubts_[path] =
      fmt::format("{}: shot {} is not stored: there is not enough memory", path.string(), shot_id);
  note(fail(doubts_[path]));
}

void SessionFolder::tend() {
  for (RecordFile* file : files()) {
    note(file->retry());
    const auto there = file->still_there();
    note(there);
    if (!there) doubts_[file->path()] = there.error().message;
  }
}

void SessionFolder::sync() {
  for (RecordFile* file : files()) note(file->sync());
  const fs::path photographs = folder_ / "photographs";
  std::error_code error;
  if (!fs::is_directory(photographs, error) || config::sync_folder(photographs)) return;
  doubts_[photographs] =
      fmt::format("{}: what was kept last may be lost: {}", photographs.string(), std::strerror(errno));
  note(fail(doubts_[photographs]));
}

void SessionFolder::close() {
  tend();
  for (RecordFile* file : files()) note(file->close());
}

std::vector<std::string> SessionFolder::unstored() const {
  std::vector<std::string> lines;
  for (const RecordFile* file : {&log_.file(), &results_.file(), &flashes_.file(), &text_}) {
    const auto kinds = file->unstored();
    if (!kinds.empty())
      lines.push_back(fmt::format("{}: not stored: {}", file->path().string(), listed(kinds)));
    if (!file->doubt().empty()) lines.push_back(fmt::format("{}: {}", file->path().string(), file->doubt()));
  }
  for (const auto& [path, why] : doubts_) lines.push_back(why);
  return lines;
}

namespace {

std::string instant(std::int64_t ns) {
  return ns == strobe_msgs::flash_t::NO_TIME ? std::string() : std::to_string(ns);
}

std::string_view lamps_word(int lamps) { return lamps == 1 ? "a" : lamps == 2 ? "b" : "ab"; }

}  // namespace

std::string flashes_header() { return csv_header(flashes_columns()); }

namespace {

std::string flash_line(const strobe_msgs::shot_t& shot, const strobe_msgs::flash_t& flash) {
  return fmt::format("{:x},{},{},{},{},{},{},{},{},{}\n", static_cast<std::uint64_t>(shot.boot_id),
                     shot.shot_id, flash.flash_index, lamps_word(flash.lamps), flash.commanded_ns,
                     instant(flash.issue_start_ns), instant(flash.issue_end_ns), instant(flash.observed_a_ns),
                     instant(flash.observed_b_ns), flash.extra_edges);
}

}  // namespace

std::string flashes_lines(const strobe_msgs::shot_t& shot) {
  std::string lines;
  for (const auto& flash : shot.flashes) lines += flash_line(shot, flash);
  return lines;
}

std::set<FlashesCsv::FlashKey> FlashesCsv::flashes_in(std::istream& lines) {
  std::set<FlashKey> known;
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> cells = data::csv_cells(line);
    const auto shot = cells.size() > 3 ? shot_key_in(cells[0], cells[1]) : std::nullopt;
    const auto flash = shot ? shot_key_in("0", cells[2]) : std::nullopt;
    if (flash) known.insert({*shot, flash->shot_id});
  }
  return known;
}

Result<FlashesCsv> FlashesCsv::open(const std::filesystem::path& path) {
  auto file = CsvFile::open(path, flashes_header());
  if (!file) return tl::unexpected(file.error());
  std::ifstream lines(path);
  auto known = flashes_in(lines);
  if (!lines.is_open() || lines.bad()) return fail(path.string() + ": cannot be read");
  return FlashesCsv(std::move(*file), std::move(known));
}

Result<void> FlashesCsv::add(const strobe_msgs::shot_t& shot) {
  std::string lines;
  for (const auto& flash : shot.flashes) {
    if (known_.insert({{shot.boot_id, shot.shot_id}, flash.flash_index}).second)
      lines += flash_line(shot, flash);
  }
  if (lines.empty()) return {};
  lines.pop_back();  // the file ends each append itself
  return file_.append(lines);
}

bool LoggedTransport::receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
                              const Receiver& receiver) {
  return transport_.receive(max_wait, descriptors, receiver);
}

void LoggedTransport::publish(const std::string& channel, Bytes bytes) {
  log(channel, bytes);
  transport_.publish(channel, bytes);
}

void LoggedTransport::log(const std::string& channel, Bytes bytes) {
  folder_.log(channel, bytes, started_.wall + (clock_.read().mono - started_.mono));
}

}  // namespace strobe::host
