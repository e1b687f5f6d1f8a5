#include "host/photographs/left_photographs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <system_error>

#include "host/photographs/photograph_matcher.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

/// After it no shot waits for a photograph any more.
constexpr Duration kOver = std::chrono::hours{1};

struct Kept {
  std::map<std::int32_t, fs::path> by_shot;   ///< the first of each number
  std::map<std::string, std::int32_t> stems;  ///< as the camera named them
};

/// photographs/shot-0007-NAME of the session.
Kept kept_in(const fs::path& session) {
  Kept kept;
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator at(session / "photographs", error), end; !error && at != end;
       at.increment(error))
    files.push_back(at->path());
  std::sort(files.begin(), files.end());
  for (const fs::path& path : files) {
    const std::string stem = path.stem().string();
    int number = 0, begin = 0;
    if (std::sscanf(stem.c_str(), "shot-%d-%n", &number, &begin) != 1 || begin == 0) continue;
    kept.by_shot.try_emplace(number, path);
    kept.stems[stem.substr(static_cast<std::size_t>(begin))] = number;
  }
  return kept;
}

/// A number alone says which shot unless two boots of the session have it.
bool unique(const LeftShots& shots, const ShotKey& key) {
  return std::ranges::none_of(shots.exposures, [&](const auto& other) {
    return other.shot_id == key.shot_id && other.boot_id != key.boot_id;
  });
}

bool lacks_its_own(const LeftShots& shots, std::int32_t shot_id) {
  return std::ranges::any_of(shots.wanted, [&](const ShotKey& key) { return key.shot_id == shot_id; });
}

/// Those that are no other shot's, each exposure once, oldest first.
std::vector<OldFile> free_files(const LeftShots& shots, std::vector<OldFile> files, const Kept& kept) {
  std::erase_if(files, [&](const OldFile& file) {
    const auto of = kept.stems.find(file.path.stem().string());
    return shots.names_used.contains(file.path.filename().string()) ||
           (of != kept.stems.end() && !lacks_its_own(shots, of->second));
  });
  std::ranges::sort(files, [](const OldFile& a, const OldFile& b) {
    return a.written != b.written ? a.written < b.written : a.path < b.path;
  });
  std::set<std::string> stems;
  std::erase_if(files, [&](const OldFile& file) { return !stems.insert(file.path.stem().string()).second; });
  return files;
}

}  // namespace

std::vector<LeftPhotograph> match_left_photographs(const LeftShots& shots, std::vector<OldFile> files,
                                                   const fs::path& session, const DeviceClock& clock,
                                                   double timeout_s) {
  std::vector<LeftPhotograph> found;
  const Kept kept = kept_in(session);
  PhotographMatcher matcher(clock, timeout_s);
  for (const auto& shot : shots.exposures) {
    matcher.on_shot(shot);
    const ShotKey key{shot.boot_id, shot.shot_id};
    const auto copy = kept.by_shot.find(shot.shot_id);
    const bool has_copy = shots.wanted.contains(key) && copy != kept.by_shot.end() && unique(shots, key);
    if (has_copy) found.push_back({copy->second, key, true});
    if (has_copy || shots.photographed.contains(key)) matcher.on_taken(key);
  }
  const std::vector<OldFile> free = free_files(shots, std::move(files), kept);
  for (std::size_t i = 0; i < free.size(); ++i)
    matcher.on_photograph(static_cast<int>(i), free[i].written, free[i].written);
  if (free.empty()) return found;
  for (const PhotographDecision& decision : matcher.end(free.back().written + kOver)) {
    if (!decision.shot || !shots.wanted.contains(*decision.shot)) continue;
    found.push_back({free[static_cast<std::size_t>(decision.photograph)].path, *decision.shot, false});
  }
  return found;
}

}  // namespace strobe::host
