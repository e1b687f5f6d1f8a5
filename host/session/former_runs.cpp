#include "host/session/former_runs.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
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
#include "host/session/log_files.hpp"
#include "host/session/results_rows.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using authentication::Bytes;
using messages::Channel;
using strobe_msgs::command_t;

template <typename Message>
std::optional<Message> decoded(Bytes bytes) {
  Message message{};
  if (!messages::decode_checked(message, bytes.data(), bytes.size()) || !messages::in_range(message))
    return std::nullopt;
  return message;
}

class RunReader {
 public:
  RunReader(const std::string& rig, const authentication::Key& key, FormerRuns& runs)
      : rig_(rig), key_(key), seal_(key), runs_(runs) {
    for (const Channel channel :
         {Channel::command, Channel::event, Channel::status, Channel::shot, Channel::frame, Channel::readout})
      channels_[static_cast<std::size_t>(channel)] = messages::channel_name(rig, channel);
  }

  /// Past records that a power cut tore.
  void read(const fs::path& path) {
    wire::LogReader log(path);
    for (wire::LogRecord record; log.next(record);) {
      if (record.channel == name(Channel::command)) {
        take_command(record.bytes);
      } else if (const auto opened = seal_.open(record.channel, record.bytes)) {
        take(record.channel, opened->message, HostTime{microseconds{record.wall_us}});
      }
    }
  }

 private:
  const std::string& name(Channel channel) const { return channels_[static_cast<std::size_t>(channel)]; }

  /// Only its own commands are in a host's log.
  void take_command(Bytes bytes) {
    const auto body = authentication::unseal(key_, rig_, bytes);
    const auto command = body ? decoded<command_t>(*body) : std::nullopt;
    if (!command || command->kind != command_t::FIRE) return;
    runs_.host_ids.insert(command->host_id);
    runs_.tokens.insert({command->boot_id, command->arm_token});
  }

  void take(const std::string& channel, Bytes bytes, HostTime heard) {
    if (channel == name(Channel::event)) {
      if (auto event = decoded<strobe_msgs::event_t>(bytes)) runs_.events.push_back(std::move(*event));
    } else if (channel == name(Channel::shot)) {
      if (auto shot = decoded<strobe_msgs::shot_t>(bytes))
        runs_.shots.try_emplace({shot->boot_id, shot->shot_id}, std::move(*shot));
    } else if (channel == name(Channel::frame)) {
      if (auto frame = decoded<strobe_msgs::frame_t>(bytes); frame && frame->boot_id != 0)
        runs_.frames.try_emplace({frame->boot_id, frame->shot_id}, std::move(*frame));
    } else if (channel == name(Channel::readout)) {
      // Numbers that could not be had are no less a readout.
      strobe_msgs::readout_t readout;
      if (messages::decode_checked(readout, bytes.data(), bytes.size()))
        runs_.read_out.insert({readout.boot_id, readout.shot_id});
    } else if (channel == name(Channel::status)) {
      if (const auto status = decoded<strobe_msgs::status_t>(bytes))
        runs_.heartbeats.push_back(
            {status->boot_id,
             {from_ns(status->mono_ns), from_ns<WallTime>(status->wall_ns), Duration{status->boot_time_ns}},
             heard});
    }
  }

  const std::string& rig_;
  const authentication::Key& key_;
  authentication::PacketSeal seal_;
  FormerRuns& runs_;
  std::array<std::string, messages::kChannelKinds.size()> channels_;
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
  return former;
}

}  // namespace strobe::host
