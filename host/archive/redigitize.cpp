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
#include "common/messages/parsed_json.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/archive/stored_digitizations.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/photographs/digitization_json.hpp"
#include "host/session/session_folder.hpp"

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
std::string kept_name(const StoredShot& shot) {
  return (fs::path("photographs") / shot.photograph->filename()).string();
}

std::string file_text(const StoredShot& shot, const MeasuredPhotograph& measured, const Author& author) {
  digitize::Digitization found = measured.found;
  found.frame.shot_id = shot.key.shot_id;
  ordered_json more;
  more["boot_id"] = fmt::format("{:x}", static_cast<std::uint64_t>(shot.key.boot_id));
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

/// With the corrections under the name that they have in the session, to which what is kept refers, whatever their file was
/// called before. A failure names that.
Result<MeasuredPhotograph> measure_to_keep(const StoredSession& session, const StoredShot& shot,
                                           const std::string& text, const std::string& file_name,
                                           int number) {
  const std::string kept = corrections_name(session, shot.key, number);
  const auto corrections = digitize::parse_corrections(text, kept);
  if (!corrections) return tl::unexpected(corrections.error());
  auto measured = redigitize(session, shot, *corrections);
  if (measured) return measured;
  const std::string& words = measured.error().message;
  return fail(words.starts_with(kept) ? file_name + words.substr(kept.size()) : words);
}

/// Corrections first: a frame in the folder counts. What could not be read again is not written.
Result<void> put(const StoredSession& session, StoredShot& shot, const MeasuredPhotograph& measured,
                 const std::string& corrections, const Author& author) {
  const std::string text = file_text(shot, measured, author);
  const std::string which = fmt::format("{}: shot {}: cannot be kept", session.folder.string(), shot.name);
  if (auto readable = parse_digitization(text, shot.key, which); !readable)
    return tl::unexpected(readable.error());
  const fs::path folder = session.folder / "digitizations";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string() + ": " + error.message());
  const int number = next_number(session.folder, shot.key);
  const std::string stem = digitization_stem(session.folder, shot.key, number).string();
  if (!corrections.empty()) {
    if (auto written = config::write_file(stem + ".toml", corrections); !written)
      return tl::unexpected(written.error());
  }
  if (auto written = config::write_file(stem + ".json", text); !written)
    return tl::unexpected(written.error());
  auto digitization = read_digitization({stem + ".json", shot.key, number});
  if (!digitization) return tl::unexpected(digitization.error());
  shot.digitizations.push_back(std::move(*digitization));
  shot.result = measured_again(shot, shot.digitizations.back().frame);
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

Result<MeasuredPhotograph> redigitize(const StoredSession& session, const StoredShot& shot,
                                      const std::vector<digitize::Correction>& corrections) {
  const std::string which = fmt::format("{}: shot {}", session.folder.string(), shot.name);
  if (!shot.photograph) return fail(which + " has no photograph in the session");
  if (!shot.summary) return fail(which + ": the firmware ended in it, and its flashes' times are not known");
  auto measured = measure_photograph(
      *shot.photograph, *shot.rig,
      {effort_of(session, shot.result.host_id), flash_times_s(*shot.summary), corrections});
  if (!measured) return fail(measured.error().message);
  return std::move(*measured);
}

Result<MeasuredPhotograph> redigitize_newest(const StoredSession& session, const StoredShot& shot) {
  if (shot.digitizations.empty() || shot.digitizations.back().corrections.empty())
    return redigitize(session, shot);
  const std::string file = shot.digitizations.back().corrections.string();
  const auto text = config::read_file(file);
  if (!text) return tl::unexpected(text.error());
  const auto corrections = digitize::parse_corrections(*text, file);
  if (!corrections) return tl::unexpected(corrections.error());
  return redigitize(session, shot, *corrections);
}

Result<ChangedShot> put_correction(const StoredSession& session, const StoredShot& shot,
                                   const std::string& text, const std::string& file_name,
                                   const Author& author) {
  const auto corrections = digitize::parse_corrections(text, file_name);
  if (!corrections) return tl::unexpected(corrections.error());
  if (!shot.digitizations.empty() && !shot.digitizations.back().corrections.empty()) {
    const auto newest = config::read_file(shot.digitizations.back().corrections.string());
    if (newest && *newest == text) return ChangedShot{shot, false};
  }
  ChangedShot changed{shot, true};
  const int number = next_number(session.folder, shot.key) + (never_digitized(shot) ? 1 : 0);
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

Result<ChangedShot> take_back(const StoredSession& session, const StoredShot& shot) {
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
  changed.shot.result = changed.shot.digitizations.empty()
                            ? without_photograph(changed.shot)
                            : measured_again(changed.shot, changed.shot.digitizations.back().frame);
  return changed;
}

Completion complete(StoredSession& session) {
  Completion completion;
  if (const auto told = never_digitized_remark(session)) std::erase(session.remarks, *told);
  for (StoredShot& shot : session.shots) {
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

}  // namespace strobe::host
