#include "host/session/former_runs.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/status_t.hpp>
#include <system_error>

#include "common/authentication/packet_seal.hpp"
#include "common/authentication/seal.hpp"
#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"
#include "common/wire/log_reader.hpp"
#include "host/messages/message_decoder.hpp"
#include "host/session/session_logs.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using authentication::Bytes;
using messages::Channel;
using strobe_msgs::command_t;

class RunReader final : public MessageHandler {
 public:
  RunReader(const std::string& rig, const authentication::Key& key, FormerRuns& runs)
      : rig_(rig),
        key_(key),
        seal_(key),
        command_channel_(messages::channel_name(rig, Channel::command)),
        readout_channel_(messages::channel_name(rig, Channel::readout)),
        decoder_(rig, *this),
        runs_(runs) {}

  /// Past records that a power cut tore.
  void read(const fs::path& path) {
    wire::LogReader log(path);
    for (wire::LogRecord record; log.next(record);) {
      if (record.channel == command_channel_) {
        on_command(record.bytes);
      } else if (const auto opened = seal_.open(record.channel, record.bytes)) {
        heard_ = HostTime{microseconds{record.wall_us}};
        if (record.channel == readout_channel_) on_readout(opened->message);
        decoder_.receive(record.channel, opened->message);
      }
    }
  }
  /// What the last exception on a message said; empty: there was none.
  const std::string& fault() const { return decoder_.fault(); }

 private:
  /// Only its own commands are in a host's log.
  void on_command(Bytes bytes) {
    const auto body = authentication::unseal(key_, rig_, bytes);
    command_t command{};
    const bool good =
        body && messages::decode_checked(command, body->data(), body->size()) && messages::in_range(command);
    if (!good || command.kind != command_t::FIRE) return;
    runs_.host_ids.insert(command.host_id);
    runs_.tokens.insert({command.boot_id, command.arm_token});
  }
  /// Numbers that could not be had are no less a readout.
  void on_readout(Bytes bytes) {
    strobe_msgs::readout_t readout;
    if (messages::decode_checked(readout, bytes.data(), bytes.size()))
      runs_.read_out.insert({readout.boot_id, readout.shot_id});
  }
  void on_event(const strobe_msgs::event_t& event) override { runs_.events.push_back(event); }
  void on_shot(const strobe_msgs::shot_t& shot) override {
    runs_.shots.try_emplace({shot.boot_id, shot.shot_id}, shot);
  }
  void on_frame(const strobe_msgs::frame_t& frame) override {
    if (frame.boot_id != 0) runs_.frames.try_emplace({frame.boot_id, frame.shot_id}, frame);
  }
  void on_status(const strobe_msgs::status_t& status) override {
    runs_.heartbeats.push_back(
        {status.boot_id,
         {from_ns(status.mono_ns), from_ns<WallTime>(status.wall_ns), Duration{status.boot_time_ns}},
         heard_});
  }

  const std::string& rig_;
  const authentication::Key& key_;
  authentication::PacketSeal seal_;
  std::string command_channel_, readout_channel_;
  MessageDecoder decoder_;
  FormerRuns& runs_;
  HostTime heard_;
};

}  // namespace

int FormerRuns::counted() const {
  return static_cast<int>(std::ranges::count_if(results, [](const auto& result) { return result.second; }));
}

std::set<ShotKey> FormerRuns::unfinished() const {
  std::set<ShotKey> found;
  for (const auto& [key, shot] : shots)
    if (own(shot) && !shot.plan.dry && !results.contains(key)) found.insert(key);
  return found;
}

bool FormerRuns::may_lack_results() const {
  std::set<ShotKey> known;
  for (const auto& [key, counts] : results) known.insert(key);
  for (const auto& [key, shot] : shots)
    if (own(shot)) known.insert(key);
  return !unfinished().empty() || tokens.size() > known.size();
}

Result<std::map<ShotKey, bool>> read_result_rows(const fs::path& folder) {
  const auto read = read_results_rows(folder / "results.csv");
  if (!read) return tl::unexpected(read.error());
  std::map<ShotKey, bool> rows;
  for (const ResultsRow& row : *read) rows[row.key] = row.counts;
  return rows;
}

Result<FormerRuns> read_former_runs(const fs::path& folder, const std::string& rig,
                                    const authentication::Key& key, const fs::path& own_log) {
  FormerRuns former;
  auto runs = read_runs(folder / "runs.jsonl");
  if (!runs) return tl::unexpected(runs.error());
  former.runs = std::move(runs->runs);
  for (const RunRecord& run : former.runs) former.host_ids.insert(run.host_id);
  auto results = read_result_rows(folder);
  if (!results) return tl::unexpected(results.error());
  former.results = std::move(*results);
  std::error_code error;
  const std::vector<fs::path> logs = host_logs(folder, error);
  if (error && error != std::errc::no_such_file_or_directory)
    return fail(folder.string() + ": " + error.message());
  RunReader reader(rig, key, former);
  for (const fs::path& log : logs) {
    if (log == own_log) continue;
    if (::access(log.c_str(), R_OK) != 0) return fail(log.string() + ": " + std::strerror(errno));
    reader.read(log);
  }
  if (!reader.fault().empty()) return fail(folder.string() + ": " + reader.fault());
  return former;
}

}  // namespace strobe::host
