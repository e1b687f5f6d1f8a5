#include "host/archive/session_files.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <iterator>
#include <system_error>

#include "common/authentication/key_file.hpp"
#include "common/config/files.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

/// name.toml, or name-<utc>.toml if the run of that time kept that.
fs::path kept(const fs::path& folder, const fs::path& name, const std::string& utc) {
  const fs::path own = folder / name.parent_path() / fmt::format("{}-{}.toml", name.stem().string(), utc);
  return is_there(own) ? own : folder / name;
}

/// "20260131T093000Z" of host-20260131T093000Zb.lcmlog
std::string utc_of(const fs::path& log) {
  constexpr std::size_t kBefore = 5, kUtc = 16;
  const std::string name = log.filename().string();
  return name.size() < kBefore + kUtc ? std::string() : name.substr(kBefore, kUtc);
}

/// As the run of that time kept it.
Result<RigFile> kept_rig(const fs::path& folder, const std::string& utc) {
  const std::string path = kept(folder, "rig.toml", utc).string();
  const auto text = config::read_file(path);
  if (!text) return tl::unexpected(text.error());
  auto rig = read_rig(*text, path);
  if (rig && !rig->ball.kind_name.empty()) {
    const std::string ball = kept(folder, kept_ball_file(rig->ball), utc).string();
    const auto ball_text = config::read_file(ball);
    if (!ball_text) return tl::unexpected(ball_text.error());
    rig = with_ball_kind(*std::move(rig), *ball_text, ball);
  }
  if (!rig || !rig->camera.calibration) return rig;
  const fs::path calibration = kept(folder, *rig->camera.calibration, utc);
  const auto calibration_text = config::read_file(calibration.string());
  if (!calibration_text) return tl::unexpected(calibration_text.error());
  auto camera = with_calibration(rig->camera, *calibration_text, calibration.string());
  if (!camera) return tl::unexpected(camera.error());
  rig->calibration_text = *calibration_text;
  rig->camera = std::move(*camera);
  return rig;
}

}  // namespace

Result<SessionRigs> SessionRigs::open(const fs::path& folder, const std::string& rig_path,
                                      const std::vector<fs::path>& logs) {
  auto main = load_rig((rig_path.empty() ? folder / "rig.toml" : fs::path(rig_path)).string());
  if (!main) return tl::unexpected(main.error());
  SessionRigs rigs;
  rigs.main_ = std::make_shared<const RigFile>(std::move(*main));
  if (!rig_path.empty()) return rigs;
  for (const fs::path& log : logs) {
    auto rig = kept_rig(folder, utc_of(log));
    if (!rig) return tl::unexpected(rig.error());
    const bool same = rig->text == rigs.main_->text &&
                      rig->calibration_text == rigs.main_->calibration_text &&
                      rig->ball_text == rigs.main_->ball_text;
    if (!same)
      rigs.others_.emplace(log.filename().string(), std::make_shared<const RigFile>(std::move(*rig)));
  }
  return rigs;
}

const SessionRigs::Rig& SessionRigs::of_log(const fs::path& log) const {
  const auto other = others_.find(log.filename().string());
  return other == others_.end() ? main_ : other->second;
}

std::optional<authentication::Key> SessionRigs::key(const std::string& key_file) const {
  // The rig file names it beside the place that it was copied from.
  const std::string named = main_->key_file.value_or("");
  const auto found = authentication::find_key({key_file, is_there(named) ? named : ""});
  return found ? std::optional(found->key) : std::nullopt;
}

std::optional<int> shot_number_in(const fs::path& photograph) {
  constexpr std::string_view kBefore = "shot-";
  const std::string name = photograph.filename().string();
  if (!name.starts_with(kBefore)) return std::nullopt;
  int number = 0;
  const char* end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + kBefore.size(), end, number);
  if (read.ec != std::errc() || read.ptr == end || *read.ptr != '-' || number < 1) return std::nullopt;
  return number;
}

std::optional<fs::path> named_photograph(const fs::path& session, const std::string& name) {
  const fs::path given(name);
  if (given.parent_path() != "photographs" || given.filename().empty() || given.filename() == "..")
    return std::nullopt;
  std::error_code error;
  const fs::path path = session / given;
  return fs::is_regular_file(path, error) ? std::optional(path) : std::nullopt;
}

UnnamedPhotographs unnamed_photographs(const fs::path& session, const std::set<fs::path>& named,
                                       const std::vector<ShotKey>& without) {
  std::map<int, std::vector<fs::path>> files;
  std::error_code error;
  for (fs::directory_iterator entry(session / "photographs", error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path path = session / "photographs" / entry->path().filename();
    if (const auto number = shot_number_in(path); number && !named.contains(path))
      files[*number].push_back(path);
  }
  UnnamedPhotographs found;
  for (auto& [number, of_number] : files) {
    std::vector<ShotKey> shots;
    std::ranges::copy_if(without, std::back_inserter(shots),
                         [n = number](const ShotKey& key) { return key.shot_id == n; });
    if (shots.empty()) continue;
    std::ranges::sort(of_number);
    if (shots.size() == 1 && of_number.size() == 1) {
      found.of_shot[shots.front()] = of_number.front();
    } else {
      const std::string name = "photographs/" + of_number.front().filename().string();
      found.remarks.push_back(
          shots.size() > 1 ? fmt::format("{}: may show either of {} shots numbered {}, and is used for none",
                                         name, shots.size(), number)
                           : fmt::format("{} and {} more may show shot {}; none of them is used", name,
                                         of_number.size() - 1, number));
    }
  }
  return found;
}

}  // namespace strobe::host
