#include "host/interlaboratory/bundle.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ctime>
#include <iomanip>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "common/authentication/key.hpp"
#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/interlaboratory/tape_archive.hpp"
#include "host/protocol/evaluation.hpp"
#include "host/protocol/evaluation_text.hpp"
#include "host/protocol/session_protocol.hpp"
#include "host/report/hashes.hpp"
#include "host/series/select.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::interlaboratory {

namespace fs = std::filesystem;

namespace {

constexpr const char* kManifest = "MANIFEST.sha256";
constexpr const char* kAbout = "bundle.json";
constexpr const char* kResults = "results.csv";
constexpr const char* kVerdict = "verdict.txt";
constexpr const char* kLock = "session.lock";
constexpr std::uintmax_t kMaxKeyFile_bytes = 200;
constexpr std::size_t kHashDigits = 64;

using Hashes = std::map<std::string, std::string>;  ///< by the name in the session's folder

bool is_key(const fs::path& file) {
  std::error_code error;
  if (fs::file_size(file, error) > kMaxKeyFile_bytes || error) return false;
  const auto text = config::read_file(file.string());
  return text && authentication::Key::from_text(*text).has_value();
}

/// The session's files by their names in it, sorted.
Result<std::vector<std::string>> files_of(const fs::path& folder, std::vector<std::string>& left_out) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().lexically_relative(folder).generic_string();
    const bool hidden = at->path().filename().string().starts_with('.');
    if (hidden && at->is_directory() && !at->is_symlink()) at.disable_recursion_pending();
    if (hidden || name == kLock || name == kManifest || name == kAbout || name == kVerdict) continue;
    if (at->is_symlink()) return fail(at->path().string() + ": is a link, which no bundle holds");
    if (at->is_directory()) continue;
    if (!at->is_regular_file()) return fail(at->path().string() + ": is no file");
    if (!is_safe_name(name)) return fail(at->path().string() + ": no bundle holds a file of such a name");
    if (is_key(at->path())) {
      left_out.push_back(name + " is a lab's key, and stays here");
      continue;
    }
    names.push_back(name);
  }
  if (error) return fail(folder.string() + ": cannot be read: " + error.message());
  std::ranges::sort(names);
  return names;
}

/// The last part of its path.
std::string name_of(const fs::path& folder) {
  fs::path whole = fs::absolute(folder).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  return whole.filename().string();
}

/// Of the newest shot or run, since 1970; 0 where there is none.
std::int64_t newest_s(const host::StoredSession& session) {
  std::string newest;
  for (const host::RunRecord& run : session.runs) newest = std::max(newest, run.utc);
  for (const host::Shot& shot : session.shots) newest = std::max(newest, shot.utc);
  std::istringstream text(newest);
  std::tm parts{};
  text >> std::get_time(&parts, "%Y-%m-%dT%H:%M:%S");
  return text ? static_cast<std::int64_t>(timegm(&parts)) : 0;
}

/// Which line of results.csv is not what the session says; nothing: all are.
Result<std::optional<std::string>> results_problem(const host::StoredSession& session) {
  const fs::path file = session.folder / kResults;
  const auto rows = host::read_results_rows(file);
  if (!rows) return tl::unexpected(rows.error());
  const auto stored = config::read_file(file.string());
  if (!stored) return tl::unexpected(stored.error());
  const std::string computed = host::results_table(session, *rows);
  if (*stored == computed) return std::optional<std::string>();
  const auto differs = std::ranges::mismatch(*stored, computed).in1;
  return std::optional(fmt::format("{}: computed again it is not the same, first in line {}", kResults,
                                   1 + std::count(stored->begin(), differs, '\n')));
}

/// By the protocol that the session was fired for, as `strobe protocol verdict` tells it; empty: for none.
Result<std::string> verdict_text(const host::StoredSession& session) {
  const auto fired_for = protocol::protocol_of_session(session.folder);
  if (!fired_for) return tl::unexpected(fired_for.error());
  if (!*fired_for) return std::string();
  const std::vector<host::Shot> shots = host::series_shots(session, "");
  const auto evaluation = protocol::evaluate((*fired_for)->protocol, (*fired_for)->seed, shots);
  return fmt::format("{}\n", fmt::join(protocol::text((*fired_for)->protocol, evaluation), "\n"));
}

std::string manifest_text(const Hashes& hashes) {
  std::string text;
  for (const auto& [name, hash] : hashes) text += hash + "  " + name + "\n";
  return text;
}

Result<Hashes> read_manifest(const std::string& text, const std::string& where) {
  Hashes hashes;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const bool good = line.size() > kHashDigits + 2 && line.substr(kHashDigits, 2) == "  " &&
                      line.find_first_not_of("0123456789abcdef") == kHashDigits;
    if (!good) return fail(fmt::format("{}: {}:{}: no hash and name", where, kManifest, number));
    hashes[line.substr(kHashDigits + 2)] = line.substr(0, kHashDigits);
  }
  return hashes;
}

/// The one folder in which all names are; empty: there is none.
std::string common_folder(const std::vector<std::string>& names) {
  const std::string first = names.front().substr(0, names.front().find('/'));
  const bool all =
      std::ranges::all_of(names, [&](const std::string& name) { return name.starts_with(first + "/"); });
  return all ? first : "";
}

void compare_files(const fs::path& folder, const std::vector<std::string>& names, const Hashes& manifest,
                   BundleCheck& check) {
  const std::set<std::string> there(names.begin(), names.end());
  for (const auto& [name, hash] : manifest) {
    if (!there.contains(name)) {
      check.problems.push_back(name + ": is missing");
      continue;
    }
    const auto found = report::sha256_of_file(folder / name);
    if (!found)
      check.problems.push_back(found.error().message);
    else if (*found != hash)
      check.problems.push_back(name + ": is not what was handed over");
  }
  for (const std::string& name : names)
    if (name != kManifest && !manifest.contains(name))
      check.problems.push_back(name + ": is not in the manifest");
}

Result<void> compute_again(const fs::path& folder, const host::ReadSessionOptions& reading,
                           BundleCheck& check) {
  const auto session = host::read_session(folder, reading);
  if (!session) return tl::unexpected(session.error());
  check.remarks.insert(check.remarks.end(), session->remarks.begin(), session->remarks.end());
  check.shots = session->shots.size();
  check.counted = static_cast<std::size_t>(
      std::ranges::count_if(session->shots, [](const host::Shot& shot) { return !shot.rejected; }));
  const auto problem = results_problem(*session);
  if (!problem) return tl::unexpected(problem.error());
  if (*problem) check.problems.push_back(**problem);
  const auto verdict = verdict_text(*session);
  const auto stored = config::read_file_if_any(folder / kVerdict);
  if (!verdict || !stored) return tl::unexpected(verdict ? stored.error() : verdict.error());
  if (*verdict != stored->value_or(""))
    check.problems.push_back(fmt::format("{}: computed again it is not the same", kVerdict));
  check.outcome = verdict->substr(0, verdict->find("\n\n"));
  return {};
}

}  // namespace

Result<Bundle> make_bundle(const host::StoredSession& session, const fs::path& archive,
                           const std::string& version) {
  const auto problem = results_problem(session);
  if (!problem) return tl::unexpected(problem.error());
  if (*problem)
    return fail(fmt::format("{}; strobe replay {} --results makes it anew",
                            (session.folder / **problem).string(), session.folder.string()));
  Bundle bundle;
  const auto names = files_of(session.folder, bundle.left_out);
  if (!names) return tl::unexpected(names.error());
  const std::string top = name_of(session.folder) + "/";
  Hashes hashes;
  std::vector<PackedFile> files;
  for (const std::string& name : *names) {
    const auto hash = report::sha256_of_file(session.folder / name);
    if (!hash) return tl::unexpected(hash.error());
    hashes[name] = *hash;
    files.push_back({top + name, session.folder / name, ""});
  }
  const std::string about =
      messages::json_text(nlohmann::ordered_json{
          {"strobe", version}, {"session", name_of(session.folder)}, {"shots", session.shots.size()}}) +
      "\n";
  hashes[kAbout] = report::sha256_hex(about);
  files.push_back({top + kAbout, "", about});
  const auto verdict = verdict_text(session);
  if (!verdict) return tl::unexpected(verdict.error());
  if (!verdict->empty()) {
    hashes[kVerdict] = report::sha256_hex(*verdict);
    files.push_back({top + kVerdict, "", *verdict});
  }
  const std::string manifest = manifest_text(hashes);
  files.insert(files.begin(), {top + kManifest, "", manifest});
  if (const auto packed = pack(archive, files, newest_s(session)); !packed)
    return tl::unexpected(packed.error());
  bundle.files = names->size();
  bundle.manifest_sha256 = report::sha256_hex(manifest);
  return bundle;
}

Result<BundleCheck> check_bundle(const fs::path& archive, const fs::path& into,
                                 const host::ReadSessionOptions& reading) {
  auto names = unpack(archive, into);
  if (!names) return tl::unexpected(names.error());
  BundleCheck check;
  check.session = common_folder(*names);
  const fs::path folder = into / check.session;
  const auto manifest = check.session.empty()
                            ? std::optional<std::string>()
                            : config::read_file_if_any(folder / kManifest).value_or(std::nullopt);
  if (!manifest) return fail(fmt::format("{}: is no bundle: it has no {}", archive.string(), kManifest));
  const auto hashes = read_manifest(*manifest, archive.string());
  if (!hashes) return tl::unexpected(hashes.error());
  for (std::string& name : *names) name.erase(0, check.session.size() + 1);
  check.files = names->size() - 1;
  check.manifest_sha256 = report::sha256_hex(*manifest);
  const auto about = messages::parsed_json<nlohmann::ordered_json>(
      config::read_file((folder / kAbout).string()).value_or(""));
  if (about.is_object()) check.version = messages::value_of<std::string>(about, "strobe");
  compare_files(folder, *names, *hashes, check);
  if (const auto done = compute_again(folder, reading, check); !done)
    check.problems.push_back("cannot be computed again: " + done.error().message);
  return check;
}

}  // namespace strobe::interlaboratory
