#include "host/batch/batch_row.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/config/files.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/messages/well_formed.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::frame_t;

std::string_view bytes_of(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Result<frame_t> measured_frame(const BatchShot& job, const BatchSettings& batch) {
  const Shot& shot = *job.shot;
  MeasureSettings settings{batch.effort, flash_times_s(*shot.summary), {}};
  if (!job.corrections.empty()) {
    auto corrections = digitize::parse_corrections(job.corrections, "corrections");
    if (!corrections) return tl::unexpected(corrections.error());
    settings.corrections = std::move(*corrections);
  }
  const auto measured = measure_photograph(*shot.photograph, *shot.rig, settings);
  if (!measured) return fail(measured.error().message);
  frame_t frame = messages::frame_to_lcm(measured->found.frame);
  frame.boot_id = shot.boot_id;
  frame.shot_id = shot.shot_id;
  frame.host_id = shot.host_id;
  if (frame.source.empty()) frame.source = "auto";
  return frame;
}

/// By another measurement of the photograph, in place of the one that counts.
BatchRow row_of(Shot shot, const frame_t& frame) {
  if (shot.digitizations.empty()) shot.digitizations.emplace_back();
  shot.digitizations.back().frame = frame;
  judge_again(shot);
  return {results_line(shot)};
}

}  // namespace

Result<BatchShot> batch_shot(const Shot& shot, const BatchSettings& settings) {
  BatchShot job{&shot, RowSource::none, {}};
  if (!shot.summary) return job;
  const Digitization* newest = shot.digitizations.empty() ? nullptr : &shot.digitizations.back();
  if (newest) job.source = RowSource::stored_frame;
  if (!shot.photograph || settings.stored_frames) return job;
  if (newest && newest->by_hand && newest->corrections.empty()) return job;  // a person measured all of it
  job.source = RowSource::photograph;
  if (!newest || newest->corrections.empty()) return job;
  auto text = config::read_file(newest->corrections.string());
  if (!text) return tl::unexpected(text.error());
  job.corrections = std::move(*text);
  return job;
}

std::string row_key(const BatchShot& job, const BatchSettings& settings, const std::string& photograph_hash) {
  const Shot& shot = *job.shot;
  ContentHash hash;
  hash.add(settings.version).add(std::to_string(static_cast<int>(settings.effort))).add(shot.rig->text);
  hash.add(shot.rig->calibration_text)
      .add(shot.rig->ball_text)
      .add(name(job.source))
      .add(photograph_hash)
      .add(job.corrections);
  hash.add(shot.summary ? bytes_of(messages::encode(*shot.summary)) : std::string_view());
  // What the logs tell of the shot beside its summary.
  hash.add(results_line(shot));
  if (job.source == RowSource::stored_frame)
    hash.add(bytes_of(messages::encode(shot.digitizations.back().frame)));
  return hash.digits();
}

BatchRow failed_row(const Shot& shot, const std::string& why) {
  Shot result = shot;
  const reduction::FlagSet flags = result.readout.flags;
  if (shot.summary) result.readout = empty_readout(*shot.summary, flags);
  result.rejected = why;
  return {results_line(result), true};
}

BatchRow measure(const BatchShot& job, const BatchSettings& settings) {
  const Shot& shot = *job.shot;
  switch (job.source) {
    case RowSource::none:
      return {results_line(shot)};
    case RowSource::stored_frame:
      return row_of(shot, shot.digitizations.back().frame);
    case RowSource::photograph:
      break;
  }
  try {
    const auto frame = measured_frame(job, settings);
    if (!frame) return failed_row(shot, "photograph not measured: " + frame.error().message);
    return row_of(shot, *frame);
  } catch (const std::exception& error) {
    return failed_row(shot, std::string("photograph not measured: ") + error.what());
  }
}

std::vector<Column> batch_columns() {
  std::vector<Column> columns = results_columns();
  columns.insert(columns.end(),
                 {{"session", "string", "", "folder of the session, by its name"},
                  {"photograph", "string", "", "the shot's photograph in its session; empty: none is kept"},
                  {"digitized", "string", "",
                   "what the numbers come from: photograph (measured again), stored_frame, none"},
                  {"key", "string", "", "hash of all that the row depends on"},
                  {"batch", "string", "", "hash of the batch's version, rig file, calibration and options"}});
  return columns;
}

std::string_view name(RowSource source) {
  switch (source) {
    case RowSource::photograph:
      return "photograph";
    case RowSource::stored_frame:
      return "stored_frame";
    case RowSource::none:
      break;
  }
  return "none";
}

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::int64_t kNs_per_s = 1'000'000'000;

std::string failure(const fs::path& path) { return path.string() + ": " + std::strerror(errno); }

}  // namespace

BatchJournal::~BatchJournal() {
  if (fd_ >= 0) ::close(fd_);
}

/// Returns false if it is no row.
bool BatchJournal::load_line(const std::string& line) {
  const json object = messages::parsed_json<json>(line);
  if (!object.is_object()) return false;
  const std::string key = messages::value_of<std::string>(object, "key"),
                    results = messages::value_of<std::string>(object, "results");
  if (key.empty() || results.empty()) return false;
  rows_[key] = {results, messages::value_of<std::int64_t>(object, "failed") != 0};
  PhotographStamp stamp{messages::value_of<std::string>(object, "photograph"),
                        messages::value_of<std::int64_t>(object, "size"),
                        messages::value_of<std::int64_t>(object, "changed_ns"),
                        messages::value_of<std::string>(object, "hash")};
  if (!stamp.hash.empty()) stamps_[stamp.path] = std::move(stamp);
  return true;
}

Result<void> BatchJournal::load(const fs::path& path, bool own) {
  std::ifstream file(path, std::ios::binary);
  off_t whole = 0;
  bool torn = false;
  for (std::string line; std::getline(file, line);) {
    torn = file.eof();  // without its end: cut short
    if (torn) break;
    load_line(line);
    whole += static_cast<off_t>(line.size()) + 1;
  }
  if (!file.is_open() || file.bad()) return fail(failure(path));
  if (own && torn && ::ftruncate(fd_, whole) != 0) return fail(failure(path));
  return {};
}

Result<std::unique_ptr<BatchJournal>> BatchJournal::open(const fs::path& folder, const std::string& name) {
  std::unique_ptr<BatchJournal> journal(new BatchJournal);
  journal->path_ = folder / name;
  journal->fd_ = ::open(journal->path_.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  if (journal->fd_ < 0) return fail(failure(journal->path_));
  struct stat opened {};
  if (::fstat(journal->fd_, &opened) != 0 || !S_ISREG(opened.st_mode))
    return fail(journal->path_.string() + ": not a regular file");
  if (::flock(journal->fd_, LOCK_EX | LOCK_NB) != 0)
    return fail(journal->path_.string() + ": another batch is writing it");
  std::vector<fs::path> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string file = entry.path().filename().string();
    if (file.starts_with("done") && file.ends_with(".jsonl")) paths.push_back(entry.path());
  }
  if (error) return fail(folder.string() + ": " + error.message());
  std::ranges::sort(paths);
  for (const fs::path& path : paths) {
    if (auto loaded = journal->load(path, path == journal->path_); !loaded)
      return tl::unexpected(loaded.error());
  }
  if (!config::sync_folder(folder)) return fail(failure(folder));
  return journal;
}

std::optional<BatchRow> BatchJournal::find(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = rows_.find(key);
  return found == rows_.end() ? std::nullopt : std::optional(found->second);
}

Result<PhotographStamp> BatchJournal::stamp(const fs::path& photograph) const {
  struct stat now {};
  if (::stat(photograph.c_str(), &now) != 0) return fail(failure(photograph));
  PhotographStamp stamp{
      photograph.string(), now.st_size, now.st_mtim.tv_sec * kNs_per_s + now.st_mtim.tv_nsec, {}};
  {
    const std::lock_guard lock(mutex_);
    const auto known = stamps_.find(stamp.path);
    if (known != stamps_.end() && known->second.size == stamp.size &&
        known->second.changed_ns == stamp.changed_ns)
      return known->second;
  }
  const auto hash = hash_of_file(stamp.path);
  if (!hash) return tl::unexpected(hash.error());
  stamp.hash = *hash;
  return stamp;
}

Result<void> BatchJournal::add(const std::string& key, const BatchRow& row,
                               const std::optional<PhotographStamp>& photograph) {
  nlohmann::ordered_json object;
  object["key"] = key;
  object["results"] = row.results;
  object["failed"] = row.failed ? 1 : 0;
  if (photograph) {
    object["photograph"] = photograph->path;
    object["size"] = photograph->size;
    object["changed_ns"] = photograph->changed_ns;
    object["hash"] = photograph->hash;
  }
  const std::string line = messages::json_text(object) + "\n";
  const std::lock_guard lock(mutex_);
  if (!config::write_all(fd_, line) || ::fdatasync(fd_) != 0) return fail(failure(path_));
  rows_[key] = row;
  return {};
}

}  // namespace strobe::host
