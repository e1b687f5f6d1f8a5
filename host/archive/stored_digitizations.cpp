#include "host/archive/stored_digitizations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <system_error>

#include "common/config/files.hpp"
#include "common/messages/json_conversions.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

template <typename Number>
bool take(std::string_view& text, Number& number, int base) {
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (read.ec != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return true;
}

bool take(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

/// A digitization's times are those of the flashes, which are found anew; one that matched none (null) is read like the
/// others. Whether there was such an image.
bool give_times(nlohmann::json& object) {
  bool given = false;
  if (!object.is_object() || !object.contains("images") || !object["images"].is_array()) return false;
  for (nlohmann::json& image : object["images"]) {
    if (!image.is_object() || (image.contains("time_s") && !image["time_s"].is_null())) continue;
    image["time_s"] = 0.0;
    given = true;
  }
  return given;
}

}  // namespace

std::optional<DigitizationFile> digitization_file(const fs::path& path) {
  const std::string name = path.filename().string();
  std::string_view rest = name;
  DigitizationFile file{path, {}, 0};
  std::uint64_t boot = 0;
  const bool good = take(rest, "shot-") && take(rest, file.key.shot_id, 10) && take(rest, "-") &&
                    take(rest, boot, 16) && take(rest, "-") && take(rest, file.number, 10) && rest == ".json";
  if (!good || file.key.shot_id < 1 || file.number < 1) return std::nullopt;
  file.key.boot_id = static_cast<std::int64_t>(boot);
  return file;
}

Result<std::map<ShotKey, std::vector<DigitizationFile>>> digitization_files(const fs::path& session) {
  std::map<ShotKey, std::vector<DigitizationFile>> files;
  std::error_code error;
  for (fs::directory_iterator entry(session / "digitizations", error), end; !error && entry != end;
       entry.increment(error)) {
    if (auto file = digitization_file(entry->path())) files[file->key].push_back(std::move(*file));
  }
  if (error && error != std::errc::no_such_file_or_directory)
    return fail((session / "digitizations").string() + ": " + error.message());
  for (auto& [key, of_shot] : files) std::ranges::sort(of_shot, {}, &DigitizationFile::number);
  return files;
}

fs::path digitization_stem(const fs::path& session, const ShotKey& key, int number) {
  return session / "digitizations" /
         fmt::format("shot-{:04}-{:x}-{}", key.shot_id, static_cast<std::uint64_t>(key.boot_id), number);
}

Result<Digitization> parse_digitization(std::string_view text, const ShotKey& key, const std::string& name) {
  auto object = messages::parsed_json<nlohmann::json>(text);
  const bool given = give_times(object);
  const auto frame = messages::frame_from_json(given ? messages::json_text(object) : std::string(text));
  if (!frame) return fail(name + ": " + frame.error().message);
  const auto word = [&object](const char* field) {
    const auto found = object.find(field);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  Digitization digitization;
  digitization.frame = messages::frame_to_lcm(*frame);
  digitization.frame.boot_id = key.boot_id;
  digitization.frame.shot_id = key.shot_id;
  digitization.frame.photograph = word("photograph");
  if (digitization.frame.source.empty()) digitization.frame.source = "auto";
  digitization.utc = word("utc");
  digitization.who = word("who");
  digitization.by_hand = !digitization.who.empty() || digitization.frame.source == "hand";
  return digitization;
}

Result<Digitization> read_digitization(const DigitizationFile& file) {
  const auto text = config::read_file(file.path.string());
  if (!text) return tl::unexpected(text.error());
  auto digitization = parse_digitization(*text, file.key, file.path.string());
  if (!digitization) return digitization;
  digitization->file = file.path;
  fs::path corrections = file.path;
  corrections.replace_extension(".toml");
  std::error_code error;
  if (fs::exists(corrections, error)) digitization->corrections = corrections;
  return digitization;
}

}  // namespace strobe::host
