#include "host/archive/redigitize.hpp"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <system_error>

#include "common/config/files.hpp"
#include "common/messages/json_conversions.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/photographs/digitization_json.hpp"
#include "host/session/session_folder.hpp"
#include "host/text/text.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// As the words of the run's command say.
digitize::Effort effort_of(const StoredSession& session, std::int64_t host_id) {
  constexpr std::string_view kOption = "--effort";
  std::string name = "standard";
  for (const RunRecord& run : session.runs) {
    if (run.host_id != host_id) continue;
    for (std::size_t i = 0; i < run.command.size(); ++i) {
      const std::string& word = run.command[i];
      if (word == kOption && i + 1 < run.command.size()) name = run.command[i + 1];
      if (word.starts_with(std::string(kOption) + "=")) name = word.substr(kOption.size() + 1);
    }
  }
  return digitize::effort_from_name(name).value_or(digitize::Effort::standard);
}

/// "photographs/shot-0003-NAME"
std::string kept_name(const Shot& shot) {
  return (fs::path("photographs") / shot.photograph->filename()).string();
}

std::string file_text(const Shot& shot, const MeasuredPhotograph& measured, const Author& author) {
  digitize::Digitization found = measured.found;
  found.frame.shot_id = shot.shot_id;
  ordered_json more;
  more["boot_id"] = fmt::format("{:x}", static_cast<std::uint64_t>(shot.boot_id));
  more["utc"] = author.utc;
  more["who"] = author.who;
  std::string text = digitization_json(found, kept_name(shot), measured.settings, true);
  text.back() = ',';
  return text + messages::json_text(more).substr(1) + "\n";
}

/// One more than that of any there was, those that were taken back included.
int next_number(const fs::path& session, const ShotKey& key) {
  int newest = 0;
  std::error_code error;
  for (fs::directory_iterator entry(session / "digitizations", error), end; !error && entry != end;
       entry.increment(error)) {
    fs::path name = entry->path().filename();
    while (name.has_extension() && name.extension() != ".json") name = name.stem();
    if (const auto file = digitization_file(name); file && file->key == key)
      newest = std::max(newest, file->number);
  }
  return newest + 1;
}

std::string corrections_name(const StoredSession& session, const ShotKey& key, int number) {
  return digitization_stem(session.folder, key, number).filename().string() + ".toml";
}

/// With the corrections under the name that they have in the session, to which what is kept refers, whatever
/// their file was called before. A failure names that.
Result<MeasuredPhotograph> measure_to_keep(const StoredSession& session, const Shot& shot,
                                           const std::string& text, const std::string& file_name,
                                           int number) {
  const std::string kept = corrections_name(session, shot.key(), number);
  const auto corrections = digitize::parse_corrections(text, kept);
  if (!corrections) return tl::unexpected(corrections.error());
  auto measured = redigitize(session, shot, *corrections);
  if (measured) return measured;
  const std::string& words = measured.error().message;
  return fail(words.starts_with(kept) ? file_name + words.substr(kept.size()) : words);
}

/// Corrections first: a frame in the folder counts. What could not be read again is not written.
Result<void> put(const StoredSession& session, Shot& shot, const MeasuredPhotograph& measured,
                 const std::string& corrections, const Author& author) {
  const std::string text = file_text(shot, measured, author);
  const std::string which = fmt::format("{}: shot {}: cannot be kept", session.folder.string(), shot.name);
  if (auto readable = parse_digitization(text, shot.key(), which); !readable)
    return tl::unexpected(readable.error());
  const fs::path folder = session.folder / "digitizations";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": " + error.message());
  const int number = next_number(session.folder, shot.key());
  const std::string stem = digitization_stem(session.folder, shot.key(), number).string();
  if (!corrections.empty()) {
    if (auto written = config::write_file(stem + ".toml", corrections); !written)
      return tl::unexpected(written.error());
  }
  if (auto written = config::write_file(stem + ".json", text); !written)
    return tl::unexpected(written.error());
  auto digitization = read_digitization({stem + ".json", shot.key(), number});
  if (!digitization) return tl::unexpected(digitization.error());
  shot.digitizations.push_back(std::move(*digitization));
  judge_again(shot);
  return {};
}

Result<void> renamed(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) return fail(from.string() + ": cannot be renamed: " + error.message());
  return {};
}

}  // namespace

Author author_now() {
  std::array<char, 256> machine{};
  const bool named = ::gethostname(machine.data(), machine.size() - 1) == 0;
  const passwd* user = ::getpwuid(::geteuid());
  return {fmt::format("{}@{}", user != nullptr ? user->pw_name : std::to_string(::geteuid()),
                      named ? machine.data() : "localhost"),
          utc_for_table(MachineClock().read().wall)};
}

Result<MeasuredPhotograph> redigitize(const StoredSession& session, const Shot& shot,
                                      const std::vector<digitize::Correction>& corrections) {
  const std::string which = fmt::format("{}: shot {}", session.folder.string(), shot.name);
  if (!shot.photograph) return fail(which + " has no photograph in the session");
  if (!shot.summary)
    return fail(which + ": strobed ended during the shot, and its flashes' times are not known");
  auto measured =
      measure_photograph(*shot.photograph, *shot.rig,
                         {effort_of(session, shot.host_id), flash_times_s(*shot.summary), corrections});
  if (!measured) return fail(measured.error().message);
  return std::move(*measured);
}

Result<MeasuredPhotograph> redigitize_newest(const StoredSession& session, const Shot& shot) {
  if (shot.digitizations.empty() || shot.digitizations.back().corrections.empty())
    return redigitize(session, shot);
  const std::string file = shot.digitizations.back().corrections.string();
  const auto text = config::read_file(file);
  if (!text) return tl::unexpected(text.error());
  const auto corrections = digitize::parse_corrections(*text, file);
  if (!corrections) return tl::unexpected(corrections.error());
  return redigitize(session, shot, *corrections);
}

Result<ChangedShot> put_correction(const StoredSession& session, const Shot& shot, const std::string& text,
                                   const std::string& file_name, const Author& author) {
  const auto corrections = digitize::parse_corrections(text, file_name);
  if (!corrections) return tl::unexpected(corrections.error());
  if (!shot.digitizations.empty() && !shot.digitizations.back().corrections.empty()) {
    const auto newest = config::read_file(shot.digitizations.back().corrections.string());
    if (newest && *newest == text) return ChangedShot{shot, false};
  }
  ChangedShot changed{shot, true};
  const int number = next_number(session.folder, shot.key()) + (never_digitized(shot) ? 1 : 0);
  const auto measured = measure_to_keep(session, shot, text, file_name, number);
  if (!measured) return tl::unexpected(measured.error());
  if (never_digitized(shot)) {
    const auto uncorrected = redigitize(session, shot);
    if (!uncorrected) return tl::unexpected(uncorrected.error());
    if (auto done = put(session, changed.shot, *uncorrected, "", {"", author.utc}); !done)
      return tl::unexpected(done.error());
  }
  if (auto done = put(session, changed.shot, *measured, text, author); !done)
    return tl::unexpected(done.error());
  return changed;
}

Result<ChangedShot> take_back(const StoredSession& session, const Shot& shot) {
  if (shot.digitizations.empty() || shot.digitizations.back().file.empty())
    return fail(
        fmt::format("{}: shot {} has no correction to be taken back", session.folder.string(), shot.name));
  const Digitization& newest = shot.digitizations.back();
  if (auto done = renamed(newest.file, newest.file.string() + ".undone"); !done)
    return tl::unexpected(done.error());
  if (!newest.corrections.empty()) {
    if (auto done = renamed(newest.corrections, newest.corrections.string() + ".undone"); !done)
      return tl::unexpected(done.error());
  }
  if (!config::sync_folder(session.folder / "digitizations"))
    return fail((session.folder / "digitizations").string() + ": cannot be written: " + std::strerror(errno));
  ChangedShot changed{shot, true};
  changed.shot.digitizations.pop_back();
  judge_again(changed.shot);
  return changed;
}

Completion complete(StoredSession& session) {
  Completion completion;
  if (const auto told = never_digitized_remark(session)) std::erase(session.remarks, *told);
  std::erase(session.advice, completion_advice(session));
  for (Shot& shot : session.shots) {
    if (!never_digitized(shot)) continue;
    const auto measured = redigitize(session, shot);
    const Result<void> done = measured ? put(session, shot, *measured, "", {"", author_now().utc})
                                       : Result<void>(tl::unexpected(measured.error()));
    if (done) {
      ++completion.digitized;
    } else {
      completion.problems.push_back(fmt::format("shot {}: {}", shot.name, done.error().message));
    }
  }
  return completion;
}

namespace {

/// A digitization's times are those of the flashes, which are found anew; one that matched none (null) is
/// read like the others. Whether there was such an image.
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
    return object.is_object() ? messages::value_of<std::string>(object, field) : std::string();
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
