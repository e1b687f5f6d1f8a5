#include "host/export/log_export.hpp"

#include <algorithm>
#include <system_error>

#include "common/authentication/packet_seal.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/messages/well_formed.hpp"
#include "common/wire/log_reader.hpp"
#include "host/session/session_logs.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

/// One packet, without its seal.
struct Packet {
  std::string log;
  std::int64_t record = 0;  ///< from 1
  std::int64_t logged_us = 0;
  std::string channel, kind;
  std::string sealed_by;         ///< fingerprint of the key; empty: not sealed
  std::optional<bool> verified;  ///< absent: without a key
  authentication::Bytes message;
};

std::string hexadecimal(authentication::Bytes bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

/// STROBE/<rig>/<KIND>; empty: another program's.
std::string packet_kind(const std::string& channel) {
  return channel.starts_with("STROBE/") ? channel.substr(channel.rfind('/') + 1) : std::string();
}

Packet packet_of(const wire::LogRecord& record, const std::optional<authentication::PacketSeal>& seal) {
  Packet packet;
  packet.logged_us = record.wall_us;
  packet.channel = record.channel;
  packet.kind = packet_kind(record.channel);
  const authentication::Bytes bytes(record.bytes);
  packet.message = authentication::message_of(bytes);
  if (packet.message.size() < bytes.size())
    packet.sealed_by = hexadecimal(bytes.subspan(packet.message.size() + 8, 4));
  if (seal) packet.verified = seal->open(record.channel, bytes).has_value();
  return packet;
}

template <typename Message, typename Take>
bool decode(authentication::Bytes bytes, const Take& take) {
  Message message;
  if (!messages::decode_checked(message, bytes.data(), bytes.size())) return false;
  take(message);
  return true;
}

/// Returns false if the packet is no message of its kind.
template <typename Take>
bool decode_kind(const Packet& packet, const Take& take) {
  using namespace strobe_msgs;
  if (packet.kind == "EVENT") return decode<event_t>(packet.message, take);
  if (packet.kind == "STATUS") return decode<status_t>(packet.message, take);
  if (packet.kind == "SHOT") return decode<shot_t>(packet.message, take);
  if (packet.kind == "FRAME") return decode<frame_t>(packet.message, take);
  if (packet.kind == "READOUT") return decode<readout_t>(packet.message, take);
  sealed_command_t sealed;  // the only one left
  if (!messages::decode_checked(sealed, packet.message.data(), packet.message.size())) return false;
  return decode<command_t>(authentication::Bytes(sealed.body), take);
}

bool is_kind(const std::string& kind) {
  constexpr std::array kKinds{"EVENT", "STATUS", "SHOT", "FRAME", "READOUT", "COMMAND"};
  return std::ranges::find(kKinds, kind) != kKinds.end();
}

/// take(packet) returns false if the packet is no message.
template <typename Take>
Result<LogExportRemains> read_log(const fs::path& path, const LogExportOptions& options, const Take& take) {
  std::error_code error;
  const auto size = static_cast<std::int64_t>(fs::file_size(path, error));
  if (error) return fail(path.string() + ": " + error.message());
  wire::LogReader reader(path);
  std::optional<authentication::PacketSeal> seal;
  if (options.key) seal.emplace(*options.key);
  LogExportRemains remains;
  std::int64_t end = 0, number = 0;
  const auto damaged = [&](std::int64_t upto) {
    if (upto > end && remains.first_damage < 0) remains.first_damage = end;
    remains.damaged_bytes += std::max<std::int64_t>(0, upto - end);
  };
  for (wire::LogRecord record; reader.next(record); end = reader.at()) {
    damaged(record.offset);
    ++number;
    Packet packet = packet_of(record, seal);
    if (!is_kind(packet.kind) || (!options.kinds.empty() && !options.kinds.contains(packet.kind))) continue;
    packet.log = path.filename().string();
    packet.record = number;
    ++(take(packet) ? remains.messages : remains.undecodable);
  }
  damaged(size);
  return remains;
}

std::vector<MessageCell> keys_of(const Packet& packet) {
  return {{"log", packet.log, "string", "file of the log"},
          {"record", std::to_string(packet.record), "integer", "number of the record in its log, from 1"}};
}

std::vector<MessageCell> heading_of(const Packet& packet) {
  return {{"logged_us", std::to_string(packet.logged_us), "integer", "when it was logged, since 1970 UTC"},
          {"channel", packet.channel, "string", "LCM channel"},
          {"sealed_by", packet.sealed_by, "string",
           "fingerprint of the key that sealed the packet; empty: not sealed"},
          {"verified", packet.verified ? (*packet.verified ? "true" : "false") : "", "boolean",
           "the seal is the given key's; empty: no key was given"}};
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return text;
}

}  // namespace

Result<LogExportRemains> export_rows(const fs::path& log, const LogExportOptions& options,
                                     const TakeRow& take) {
  return read_log(log, options, [&](const Packet& packet) {
    return decode_kind(packet, [&](const auto& message) {
      RowVisitor visitor(lower(packet.kind), keys_of(packet), take);
      for (MessageCell& cell : heading_of(packet)) visitor.add(std::move(cell));
      messages::visit_fields(message, visitor);
      visitor.end();
    });
  });
}

Result<LogExportRemains> export_json(const fs::path& log, const LogExportOptions& options,
                                     const std::function<void(const std::string&)>& take) {
  return read_log(log, options, [&](const Packet& packet) {
    return decode_kind(packet, [&](const auto& message) {
      nlohmann::ordered_json line;
      line["log"] = packet.log;
      line["record"] = packet.record;
      line["logged_us"] = packet.logged_us;
      line["channel"] = packet.channel;
      line["kind"] = packet.kind;
      line["sealed_by"] =
          packet.sealed_by.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(packet.sealed_by);
      line["verified"] =
          packet.verified ? nlohmann::ordered_json(*packet.verified) : nlohmann::ordered_json();
      line["message"] = JsonVisitor::object_of(message);
      take(messages::json_text(line));
    });
  });
}

Result<std::vector<fs::path>> logs_of(const fs::path& log_or_session) {
  std::error_code error;
  if (!fs::is_directory(log_or_session, error)) {
    if (fs::is_regular_file(log_or_session, error)) return std::vector{log_or_session};
    return fail(log_or_session.string() + ": no such file or folder");
  }
  auto logs = host_logs(log_or_session, error);
  if (!error && logs.empty()) logs = journals(log_or_session, error);
  if (error) return fail(log_or_session.string() + ": " + error.message());
  if (logs.empty())
    return fail(log_or_session.string() +
                ": no log of a host (host-*.lcmlog) and no journal (journal-*.lcmlog) is in it");
  return logs;
}

}  // namespace strobe::host
