#include "host/session/session_folder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <map>
#include <set>
#include <system_error>

#include "common/authentication/packet_seal.hpp"
#include "common/config/files.hpp"
#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"
#include "common/shot/shot_key.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using strobe_msgs::event_t;
using strobe_msgs::shot_t;

/// name.toml, or name-<utc>.toml where an earlier run in this folder used another one.
Result<void> keep(const fs::path& path, std::string_view text, const std::string& utc) {
  std::error_code error;
  if (!fs::exists(path, error)) return config::write_file(path, text);
  if (config::read_file(path.string()) == text) return {};
  return config::write_file(path.parent_path() / (path.stem().string() + "-" + utc + ".toml"), text);
}

fs::path unused(const fs::path& folder, const std::string& utc) {
  std::error_code error;
  fs::path path = folder / ("host-" + utc + ".lcmlog");
  for (char letter = 'b'; fs::exists(path, error) && letter <= 'z'; ++letter) {
    path = folder / ("host-" + utc + letter + ".lcmlog");
  }
  return path;
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
                                                           const KeptFile& calibration) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": " + error.message());
  std::unique_ptr<SessionFolder> result(new SessionFolder(folder, unused(folder, utc)));
  for (const auto& [name, text] :
       {KeptFile{"rig.toml", rig_text}, KeptFile{"plan.toml", plan_text}, calibration}) {
    if (name.empty()) continue;
    if (auto kept = keep(folder / name, text, utc); !kept) return tl::unexpected(kept.error());
  }
  auto results = CsvFile::open(folder / "results.csv", results_header(), earlier_results_header());
  if (!results) return tl::unexpected(results.error());
  result->results_ = std::make_unique<CsvFile>(std::move(*results));
  auto flashes = FlashesCsv::open(folder / "flashes.csv");
  if (!flashes) return tl::unexpected(flashes.error());
  result->flashes_ = std::make_unique<FlashesCsv>(std::move(*flashes));
  result->log_ = std::make_unique<lcm::LogFile>(result->log_path_.string(), "w");
  if (!result->log_->good()) return fail(result->log_path_.string() + ": cannot be written");
  return result;
}

void SessionFolder::log(const std::string& channel, const void* data, std::size_t size, WallTime wall) {
  lcm::LogEvent event{};
  event.eventnum = event_number_++;
  event.timestamp = std::chrono::floor<microseconds>(wall).time_since_epoch().count();
  event.channel = channel;
  event.datalen = static_cast<std::int32_t>(size);
  event.data = const_cast<void*>(data);  // LCM's interface; it only reads
  log_->writeEvent(&event);
  std::fflush(log_->getFilePtr());
}

Result<void> SessionFolder::add(const ShotResult& shot_result, const std::string& utc) {
  return results_->append(results_line(shot_result, utc));
}

Result<void> SessionFolder::add(const strobe_msgs::shot_t& shot) { return flashes_->add(shot); }

void SessionFolder::load_events(EventLedger& ledger, const std::string& rig,
                                const authentication::Key& key) const {
  const authentication::PacketSeal seal(key);
  const std::string events = messages::channel_name(rig, messages::Channel::event);
  const std::string shots = messages::channel_name(rig, messages::Channel::shot);
  std::map<ShotKey, std::int64_t> ended;
  std::set<ShotKey> summed_up;
  const auto enter = [&](const lcm::LogEvent& logged) {
    const auto opened = seal.open(logged.channel, {static_cast<const std::uint8_t*>(logged.data),
                                                   static_cast<std::size_t>(logged.datalen)});
    if (!opened) return;
    const auto [data, size] = std::pair(opened->message.data(), opened->message.size());
    if (logged.channel == events) {
      event_t event;
      if (!messages::decode_checked(event, data, size) || !messages::in_range(event)) return;
      ledger.add(event.boot_id, event.sequence, HostTime{});
      if (event.kind == event_t::SHOT_ENDED || event.kind == event_t::SHOT_ABORTED)
        ended[{event.boot_id, event.shot_id}] = event.sequence;
    } else if (logged.channel == shots) {
      shot_t shot;
      if (messages::decode_checked(shot, data, size)) summed_up.insert({shot.boot_id, shot.shot_id});
    }
  };
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("host-") || !name.ends_with(".lcmlog") || entry.path() == log_path_) continue;
    lcm::LogFile log(entry.path().string(), "r");
    if (!log.good()) continue;
    while (const lcm::LogEvent* logged = log.readNextEvent()) enter(*logged);
  }
  for (const auto& [shot, sequence] : ended) {
    if (!summed_up.contains(shot)) ledger.request_again(shot.boot_id, sequence);
  }
}

}  // namespace strobe::host
