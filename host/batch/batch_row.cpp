#include "host/batch/batch_row.hpp"

#include <fmt/format.h>

#include <exception>

#include "common/config/files.hpp"
#include "common/messages/encode.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "host/archive/results_table.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/photographs/measure_photograph.hpp"
#include "host/session/results_csv.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::frame_t;

std::string_view bytes_of(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Result<frame_t> measured_frame(const BatchShot& job, const BatchSettings& batch) {
  const StoredShot& shot = *job.shot;
  MeasureSettings settings{batch.effort, flash_times_s(*shot.summary), {}};
  if (!job.corrections.empty()) {
    auto corrections = digitize::parse_corrections(job.corrections, "corrections");
    if (!corrections) return tl::unexpected(corrections.error());
    settings.corrections = std::move(*corrections);
  }
  const auto measured = measure_photograph(*shot.photograph, *shot.rig, settings);
  if (!measured) return fail(measured.error().message);
  frame_t frame = messages::frame_to_lcm(measured->found.frame);
  frame.boot_id = shot.key.boot_id;
  frame.shot_id = shot.key.shot_id;
  frame.host_id = shot.result.host_id;
  if (frame.source.empty()) frame.source = "auto";
  return frame;
}

std::string line_of(const StoredShot& shot, const ShotResult& result) {
  const auto digitization = shot.digitizations.empty() ? digitization_word(result) : digitization_word(shot);
  return results_line(result, shot.utc, shot.name, digitization);
}

BatchRow row_of(const StoredShot& shot, const frame_t& frame) {
  return {line_of(shot, measured_again(shot, frame))};
}

}  // namespace

Result<BatchShot> batch_shot(const StoredShot& shot, const BatchSettings& settings) {
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
  const StoredShot& shot = *job.shot;
  ContentHash hash;
  hash.add(settings.version).add(std::to_string(static_cast<int>(settings.effort))).add(shot.rig->text);
  hash.add(shot.rig->calibration_text).add(name(job.source)).add(photograph_hash).add(job.corrections);
  hash.add(shot.summary ? bytes_of(messages::encode(*shot.summary)) : std::string_view());
  // What the logs tell of the shot beside its summary.
  hash.add(line_of(shot, shot.result));
  if (job.source == RowSource::stored_frame)
    hash.add(bytes_of(messages::encode(shot.digitizations.back().frame)));
  return hash.digits();
}

BatchRow failed_row(const StoredShot& shot, const std::string& why) {
  ShotResult result = shot.result;
  const reduction::FlagSet flags = result.readout.flags;
  if (shot.summary) result.readout = empty_readout(*shot.summary, flags);
  result.rejected = why;
  return {line_of(shot, result), true};
}

BatchRow measure(const BatchShot& job, const BatchSettings& settings) {
  const StoredShot& shot = *job.shot;
  switch (job.source) {
    case RowSource::none:
      return {line_of(shot, shot.result)};
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

}  // namespace strobe::host
