#include "host/batch/batch_tables.hpp"

#include <fmt/format.h>
#include <sodium.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <system_error>
#include <vector>

#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/batch/batch_row.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTitle = "Results of a batch, one row per shot";

Result<void> write_table(const fs::path& path, const std::string& lines) {
  const auto columns = batch_columns();
  if (auto written = config::write_file(path, csv_header(columns) + "\n" + lines); !written) return written;
  return config::write_file(path.string() + "-metadata.json",
                            data_dictionary(path.filename().string(), kTitle, columns));
}

/// The rows of a session's table if it is of this batch: each row ends in the batch's id.
std::optional<std::string> rows_of(const fs::path& path, const std::string& id) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  const std::string all = text.str(), header = csv_header(batch_columns()) + "\n";
  if (!all.starts_with(header)) return std::nullopt;
  std::string rows = all.substr(header.size());
  if (!rows.empty() && !rows.ends_with("," + id + "\n")) return std::nullopt;
  return rows;
}

}  // namespace

std::vector<BatchSession> batch_sessions(const std::vector<std::string>& paths) {
  std::vector<BatchSession> sessions;
  std::set<std::string> known;
  std::map<std::string, int> names;
  for (const std::string& given : paths) {
    fs::path path = fs::path(given).lexically_normal();
    if (path.filename().empty()) path = path.parent_path();
    if (!known.insert(path.string()).second) continue;
    std::error_code error;
    fs::path whole = fs::absolute(path, error).lexically_normal();
    if (whole.filename().empty()) whole = whole.parent_path();
    sessions.push_back({path.string(), whole.filename().string()});
    ++names[sessions.back().name];
  }
  for (BatchSession& session : sessions) {
    if (names[session.name] > 1 || session.name == "results")
      session.name += "-" + ContentHash().add(session.path).digits().substr(0, 8);
  }
  return sessions;
}

Result<void> write_manifest(const fs::path& folder, const BatchManifest& manifest) {
  nlohmann::ordered_json json;
  json["batch"] = manifest.id;
  json["sessions"] = manifest.sessions;
  const std::string text = messages::json_text(json, 1) + "\n";
  const fs::path path = folder / "batch.json";
  std::error_code error;
  if (fs::exists(path, error) && config::read_file(path.string()) == text) return {};
  return config::write_file(path, text);
}

Result<BatchManifest> read_manifest(const fs::path& folder) {
  const std::string path = folder / "batch.json";
  const auto text = config::read_file(path);
  if (!text) return tl::unexpected(text.error());
  const auto json = messages::parsed_json<nlohmann::json>(*text);
  BatchManifest manifest;
  if (json.is_object() && json.contains("batch") && json["batch"].is_string() && json.contains("sessions") &&
      json["sessions"].is_array()) {
    manifest.id = json["batch"].get<std::string>();
    for (const auto& name : json["sessions"])
      if (name.is_string()) manifest.sessions.push_back(name.get<std::string>());
    if (manifest.sessions.size() == json["sessions"].size()) return manifest;
  }
  return fail(path + ": not what strobe batch wrote");
}

Result<void> write_session_table(const fs::path& folder, const std::string& session,
                                 const std::string& lines) {
  return write_table(folder / (session + ".csv"), lines);
}

Result<void> write_session_remarks(const fs::path& folder, const std::string& session,
                                   const std::vector<std::string>& remarks) {
  const fs::path path = folder / (session + ".remarks.txt");
  std::error_code error;
  if (remarks.empty()) return fs::remove(path, error), Result<void>();
  return config::write_file(path, fmt::format("{}\n", fmt::join(remarks, "\n")));
}

Result<int> merge_tables(const std::vector<fs::path>& folders, const fs::path& out) {
  std::optional<BatchManifest> manifest;
  for (const fs::path& folder : folders) {
    auto one = read_manifest(folder);
    if (!one) return tl::unexpected(one.error());
    if (manifest && (one->id != manifest->id || one->sessions != manifest->sessions))
      return fail(folder.string() + ": another batch than that of " + folders.front().string());
    manifest = std::move(*one);
  }
  std::vector<std::string> names = manifest->sessions, missing;
  std::ranges::sort(names);
  std::string lines;
  for (const std::string& name : names) {
    std::optional<std::string> rows;
    for (const fs::path& folder : folders)
      if (!rows) rows = rows_of(folder / (name + ".csv"), manifest->id);
    if (rows) lines += *rows;
    if (!rows) missing.push_back(name);
  }
  if (!missing.empty())
    return fail(fmt::format("{} of {} sessions are not finished: {}{}", missing.size(), names.size(),
                            missing.front(), missing.size() > 1 ? " ..." : ""));
  if (auto written = write_table(out / "results.csv", lines); !written)
    return tl::unexpected(written.error());
  return static_cast<int>(std::ranges::count(lines, '\n'));
}

namespace {

constexpr std::size_t kHash_bytes = 16;

std::string hexadecimal(const std::array<unsigned char, kHash_bytes>& hash) {
  std::string text;
  for (const unsigned char byte : hash) text += fmt::format("{:02x}", byte);
  return text;
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

ContentHash::ContentHash() = default;

ContentHash& ContentHash::add(std::string_view part) {
  parts_ += fmt::format("{}:", part.size());
  parts_ += part;
  return *this;
}

std::string ContentHash::digits() const {
  std::array<unsigned char, kHash_bytes> hash{};
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(parts_.data()),
                     parts_.size(), nullptr, 0);
  return hexadecimal(hash);
}

Result<std::string> hash_of_file(const std::string& path) {
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) return fail(path + ": " + std::strerror(errno));
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, kHash_bytes);
  std::vector<unsigned char> piece(std::size_t{1} << 20);
  while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), file.get()))
    crypto_generichash_update(&state, piece.data(), size);
  if (std::ferror(file.get()) != 0) return fail(path + ": " + std::strerror(errno));
  std::array<unsigned char, kHash_bytes> hash{};
  crypto_generichash_final(&state, hash.data(), hash.size());
  return hexadecimal(hash);
}

std::string batch_id(const BatchSettings& settings, const std::string& rig_text) {
  return ContentHash()
      .add(settings.version)
      .add(rig_text)
      .add(settings.calibration_text)
      .add(std::to_string(static_cast<int>(settings.effort)))
      .add(settings.stored_frames ? "stored" : "again")
      .digits()
      .substr(0, 16);
}

Result<RigFile> calibrated(RigFile rig, const BatchSettings& settings) {
  if (settings.calibration_name.empty()) return rig;
  auto camera = with_calibration(rig.camera, settings.calibration_text, settings.calibration_name);
  if (!camera) return tl::unexpected(camera.error());
  rig.camera = std::move(*camera);
  rig.calibration_text = settings.calibration_text;
  return rig;
}

}  // namespace strobe::host
