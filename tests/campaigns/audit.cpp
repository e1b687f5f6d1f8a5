#include "tests/campaigns/audit.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include "common/authentication/packet_seal.hpp"
#include "common/shot/shot_key.hpp"
#include "common/wire/log_reader.hpp"

namespace strobe::loss {

namespace {

using campaigns::Verdict;
using strobe_msgs::event_t;
using strobe_msgs::readout_t;
using strobe_msgs::shot_t;
using wire::LogReader;
using wire::LogRecord;

using EventKey = std::pair<std::int64_t, std::int64_t>;  // boot, sequence

struct Range {
  std::int64_t first = 0, last = 0;
};

template <typename Message>
bool decode(const LogRecord& record, const char* kind, Message& message) {
  return record.channel.ends_with(kind) &&
         message.decode(record.bytes.data(), 0, static_cast<int>(record.bytes.size())) >= 0;
}

std::vector<std::filesystem::path> logs(const std::filesystem::path& folder, const std::string& before) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(before) && name.ends_with(".lcmlog")) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

class Auditor {
 public:
  Auditor() {
    for (const char* what :
         {"missing events", "missing summaries", "cut off", "cut off, reported", "readouts",
          "readouts flagged", "readouts twice", "readouts incomplete, unflagged"})
      audit_.count(what, 0.0);  // told even if there is none
  }

  void read_journal(const std::filesystem::path& path) {
    LogReader log(path);
    std::int64_t expected = 1, end = 0;
    audit_.count("boots");
    for (LogRecord record; log.next(record); end = log.at()) {
      audit_.count("torn bytes", static_cast<double>(record.offset - end));
      event_t event{};
      shot_t shot{};
      if (decode(record, "/EVENT", event)) {
        if (event.sequence != expected)
          audit_.violate("{}: event {} follows {}", path.filename().string(), event.sequence, expected - 1);
        expected = event.sequence + 1;
        if (record.wall_us >= newest_us_) {
          newest_us_ = record.wall_us;
          newest_boot_ = event.boot_id;
        }
        journalled_[{event.boot_id, event.sequence}] = record.bytes;
        if (event.kind == event_t::SHOT_STARTED) started_.insert({event.boot_id, event.shot_id});
        if (event.kind == event_t::REPAIRED) repairs_.push_back(event.detail);
      } else if (decode(record, "/SHOT", shot)) {
        shots_[{shot.boot_id, shot.shot_id}] = {shot.first_sequence, shot.last_sequence};
      }
    }
    audit_.count("torn bytes",
                 static_cast<double>(std::filesystem::file_size(path)) - static_cast<double>(end));
  }

  void read_host_log(const std::filesystem::path& path) {
    LogReader log(path);
    for (LogRecord record; log.next(record);) {
      event_t event{};
      shot_t shot{};
      readout_t readout{};
      strobe_msgs::status_t status{};
      if (decode(record, "/EVENT", event)) {
        const auto journalled = journalled_.find({event.boot_id, event.sequence});
        if (journalled == journalled_.end()) {
          audit_.violate("event {} of boot {:x} is on the host and in no journal", event.sequence,
                         event.boot_id);
        } else if (!std::ranges::equal(journalled->second, authentication::message_of(record.bytes))) {
          audit_.violate("event {} of boot {:x} differs from its journal", event.sequence, event.boot_id);
        }
        here_.insert({event.boot_id, event.sequence});
      } else if (decode(record, "/SHOT", shot)) {
        shots_here_.insert({shot.boot_id, shot.shot_id});
      } else if (decode(record, "/READOUT", readout)) {
        read_out(readout);
      } else if (decode(record, "/STATUS", status)) {
        std::int64_t& heard = heard_[status.boot_id];
        heard = std::max(heard, status.last_sequence);
      }
    }
  }

  Verdict end() {
    audit_.count("events journalled", static_cast<double>(journalled_.size()));
    for (const auto& [key, bytes] : journalled_) {
      if (here_.contains(key)) continue;
      if (!due(key.first, key.second)) {
        audit_.count("events later");
        continue;
      }
      audit_.count("missing events");
      audit_.violate("event {} of boot {:x} is in the journal and on no host", key.second, key.first);
    }
    audit_.count("summaries", static_cast<double>(shots_.size()));
    for (const auto& [key, range] : shots_) {
      if (shots_here_.contains(key) || !due(key.boot_id, range.last)) continue;
      audit_.count("missing summaries");
      audit_.violate("the summary of shot {} is in the journal and on no host", key.shot_id);
    }
    for (const ShotKey& key : started_)
      if (!shots_.contains(key)) account_for(key);
    return std::move(audit_);
  }

 private:
  bool due(std::int64_t boot, std::int64_t sequence) const {
    const auto heard = heard_.find(boot);
    return boot != newest_boot_ || heard == heard_.end() || sequence <= heard->second;
  }

  void read_out(const readout_t& readout) {
    const ShotKey key{readout.boot_id, readout.shot_id};
    audit_.count("readouts");
    if (!read_out_.insert(key).second) {
      audit_.count("readouts twice");
      audit_.violate("shot {} of boot {:x} was read out twice", key.shot_id, key.boot_id);
    }
    const bool flagged =
        std::find(readout.flags.begin(), readout.flags.end(), "events_missing") != readout.flags.end();
    audit_.count("readouts flagged", flagged ? 1.0 : 0.0);
    if (flagged || whole(key)) return;
    audit_.count("readouts incomplete, unflagged");
    audit_.violate("shot {} was read out with events missing, and no flag says so", key.shot_id);
  }

  bool whole(const ShotKey& key) const {
    const auto shot = shots_.find(key);
    if (shot == shots_.end()) return false;
    for (std::int64_t sequence = shot->second.first; sequence <= shot->second.last; ++sequence)
      if (!here_.contains({key.boot_id, sequence})) return false;
    return true;
  }

  /// A shot whose end the firmware did not live to write.
  void account_for(const ShotKey& key) {
    audit_.count("cut off");
    const std::string words =
        fmt::format("boot {:016x}: shot {} has no end", static_cast<std::uint64_t>(key.boot_id), key.shot_id);
    const bool reported = std::any_of(repairs_.begin(), repairs_.end(),
                                      [&](const std::string& detail) { return detail.starts_with(words); });
    if (reported)
      audit_.count("cut off, reported");
    else
      audit_.violate("nobody said that shot {} has no end", key.shot_id);
  }

  Verdict audit_;
  std::map<EventKey, std::vector<std::uint8_t>> journalled_;
  std::map<ShotKey, Range> shots_;
  std::set<ShotKey> started_;
  std::vector<std::string> repairs_;
  std::int64_t newest_boot_ = 0;
  std::int64_t newest_us_ = 0;                  // its last record
  std::map<std::int64_t, std::int64_t> heard_;  // by boot: the newest event that a status reported
  std::set<EventKey> here_;
  std::set<ShotKey> shots_here_, read_out_;
};

}  // namespace

Verdict audit(const std::filesystem::path& firmware, const std::filesystem::path& host) {
  Auditor auditor;
  for (const auto& path : logs(firmware, "journal-")) auditor.read_journal(path);
  for (const auto& path : logs(host, "host-")) auditor.read_host_log(path);
  return auditor.end();
}

}  // namespace strobe::loss
